#!/usr/bin/env python3
"""Every --help within 80 columns, and every example of it as printed: it runs from the repository's root, prints within
80 columns and ends with 0; on a terminal, too, nothing is wider, warnings stand on lines of their own, progress moves.

    tests/cli/examples_test.py SIMGAP SOURCE
"""
import fcntl
import os
import pathlib
import pty
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import termios
import unittest

WIDTH = 80


def lines_of(help_text):
    """The command lines below "Example:", with their continuations joined."""
    example = help_text[help_text.index("Example:\n") + len("Example:\n"):].replace("\\\n", " ")
    return [line.strip() for line in example.splitlines() if line.strip()]


def makes(line):
    """The result directory that a line fills without reading what another line has made; nothing where it reads such, too."""
    results = re.findall(r"(-o )?\b(runs/\S+)", line)
    return results[0][1] if len(results) == 1 and results[0][0] else None


def on_a_terminal(command, folder, environment):
    """Exit code, and all that a terminal of 80 columns would be sent."""
    screen, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, WIDTH, 0, 0))
    process = subprocess.Popen(command, shell=True, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=terminal,
                               stderr=terminal)
    os.close(terminal)
    text = b""
    while True:
        try:
            piece = os.read(screen, 65536)
        except OSError:  # the last one has closed it
            break
        if not piece:
            break
        text += piece
    os.close(screen)
    return process.wait(), text.decode()


def rows_of(text):
    """What stands on each row of a terminal after all rewriting, and every state of a rewritten one."""
    return [state.replace("\x1b[K", "") for row in text.replace("\r\n", "\n").split("\n") for state in row.split("\r")]


class Examples(unittest.TestCase):
    simgap = source = None

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="simgap-examples-")))
        cls.environment = {**os.environ, "PATH": f"{cls.simgap.parent}:{os.environ['PATH']}"}
        listing = cls.help("--help")
        cls.commands = re.findall(r"^  ([a-z-]+) ", listing[listing.index("ommands:"):listing.index("Begin with:")], re.MULTILINE)

    @classmethod
    def help(cls, *arguments):
        return subprocess.run([cls.simgap, *arguments], capture_output=True, text=True, check=True).stdout

    def root(self, name):
        """A folder that holds what the repository's root holds for a user."""
        root = self.folder / name
        root.mkdir()
        for shared in ("data", "configs"):
            (root / shared).symlink_to(self.source / shared)
        return root

    def test_help_fits(self):
        self.assertEqual(len(self.commands), 22, self.commands)
        for arguments in [["--help"], *([command, "--help"] for command in self.commands)]:
            for line in self.help(*arguments).splitlines():
                self.assertLessEqual(len(line), WIDTH, (arguments, line))

    def test_every_command_has_an_example_of_itself(self):
        for command in self.commands:
            lines = lines_of(self.help(command, "--help"))
            self.assertTrue(any(line.startswith(f"simgap {command} ") for line in lines), (command, lines))

    def test_examples_run_as_printed(self):
        moved, kept = [], {}
        for command in self.commands:
            root = self.root(command)
            for line in lines_of(self.help(command, "--help")):
                with self.subTest(line):
                    result = makes(line)
                    if line in kept:  # of another command's help: what it made stands here, too, and is not made again
                        shutil.copytree(kept[line], root / result, symlinks=True)
                        continue
                    code, text = on_a_terminal(line, root, self.environment)
                    self.assertEqual(code, 0, text)
                    rows = rows_of(text)
                    for row in rows:
                        self.assertLessEqual(len(row), WIDTH, row)
                        self.assertNotRegex(row, r"(left|so far)\b.*(: its cord|another stable)", "a warning on a line of progress")
                    moved.append(len({row for row in rows if re.search(r", \d+.*(left|so far)", row)}))
                    if result:
                        kept[line] = shutil.copytree(root / result, self.folder / "kept" / str(len(kept)), symlinks=True)
            shutil.rmtree(root)
        self.assertGreater(max(moved), 3, "no progress was seen to move")

    def refusal(self, *arguments):
        done = subprocess.run([self.simgap, *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        return done.stderr

    def test_slips_of_the_pen_are_understood(self):
        self.assertIn("did you mean calibrate?", self.refusal("calibrat", "arm.yaml"))
        self.assertIn("did you mean --poses? (see simgap calibrate --help)", self.refusal("calibrate", "arm.yaml", "--pose", "x.csv"))
        self.assertIn("LOG is required (see simgap fit-motor --help)", self.refusal("fit-motor"))
        for command in self.commands:
            self.assertIn(f"(see simgap {command} --help)", self.refusal(command, "--no-such-option"))

    def test_columns_are_understood(self):
        root = self.root("columns")
        (root / "log.csv").write_text("time_s,motor_curent_A,motor_velocity_rad_s\n0,1,1\n")
        done = subprocess.run([self.simgap, "fit-friction", "log.csv", "--map", "load_torque_Nm=motor_current_A"], cwd=root, capture_output=True, text=True)
        self.assertEqual(done.returncode, 3)
        self.assertIn("did you mean motor_curent_A?", done.stderr)

    def test_standard_input_is_a_file(self):
        log = (self.source / "data/logs/shock-cord.csv.gz").read_bytes()
        root = self.root("pipe")
        for name, arguments, given in (("file", [self.source / "data/logs/shock-cord.csv.gz"], b""), ("pipe", ["-"], log)):
            subprocess.run([self.simgap, "fit-spring", *arguments, "-q", "-o", name], input=given, cwd=root, capture_output=True, check=True)
        self.assertEqual((root / "file/parameters.csv").read_bytes(), (root / "pipe/parameters.csv").read_bytes())


if __name__ == "__main__":
    Examples.simgap, Examples.source = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
