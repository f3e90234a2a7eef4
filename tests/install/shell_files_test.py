#!/usr/bin/env python3
"""Man pages and completion as installed: man renders every page without a complaint, bash completes.

    tests/install/shell_files_test.py SIMGAP
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest


class ShellFiles(unittest.TestCase):
    simgap = None

    @classmethod
    def setUpClass(cls):
        cls.share = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="simgap-shell-")))
        subprocess.run([cls.simgap, "--write-shell-files", cls.share], check=True)

    def test_man_pages_render(self):
        pages = sorted((self.share / "man/man1").iterdir())
        self.assertEqual(len(pages), 23)
        if not shutil.which("man"):
            self.skipTest("there is no man")
        for page in pages:
            done = subprocess.run(["man", "--warnings", "-l", page], capture_output=True, text=True, env={"LC_ALL": "C.UTF-8", "MANWIDTH": "80", "PATH": "/usr/bin:/bin"})
            self.assertEqual((done.returncode, done.stderr), (0, ""), page)
            for heading in ("NAME", "SYNOPSIS", "OPTIONS", "EXIT STATUS"):
                self.assertIn(heading, done.stdout, page)

    def completed(self, *words):
        """What bash offers for the last word."""
        script = f"""source {self.share}/bash-completion/completions/simgap
            COMP_WORDS=({" ".join(f"'{word}'" for word in words)}); COMP_CWORD={len(words) - 1}; _simgap; printf '%s\\n' "${{COMPREPLY[@]}}" """
        return subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True).stdout.split()

    def test_bash_completes(self):
        self.assertEqual(self.completed("simgap", "calibrate-"), ["calibrate-cameras", "calibrate-joints"])
        self.assertEqual(self.completed("simgap", "calibrate", "--opt"), ["--optimizer"])
        self.assertEqual(self.completed("simgap", "calibrate", "--evaluator", ""), ["bullet", "equilibrium"])
        self.assertEqual(self.completed("simgap", "fit-motor", "--evaluator", "b"), [])

    def test_other_shells_parse(self):
        for shell, file in (("zsh", "zsh/vendor-completions/_simgap"), ("fish", "fish/vendor_completions.d/simgap.fish")):
            text = (self.share / file).read_text()
            self.assertIn("fit-friction", text)
            if shutil.which(shell):
                subprocess.run([shell, "-n", self.share / file], check=True)


if __name__ == "__main__":
    ShellFiles.simgap = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
