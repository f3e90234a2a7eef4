#!/usr/bin/python3
"""The Python module on the program itself; skipped where python3-numpy is missing.

    tests/python/simgap_test.py SIMGAP SOURCE
"""
import os
import pathlib
import subprocess
import sys
import unittest

try:
    import numpy
except ImportError:
    print("skipped: python3-numpy not found")
    sys.exit(77)

SIMGAP, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
os.environ["SIMGAP"] = str(SIMGAP)
sys.path.insert(0, str(SOURCE / "python"))
import simgap  # noqa: E402


class Module(unittest.TestCase):
    def test_tables_survive_the_way_there_and_back(self):
        columns = {"time_s": numpy.array([0.1, 1.0 / 3.0, 1e-300]), "session": numpy.array(["a", "b,c", 'say "hi"'])}
        file = pathlib.Path(self.enterContext(__import__("tempfile").TemporaryDirectory())) / "t.csv"
        file.write_text(simgap.write_table(columns))
        found = simgap.read_table(file)
        self.assertEqual(found["time_s"].tolist(), columns["time_s"].tolist())
        self.assertEqual(found["session"].tolist(), columns["session"].tolist())
        with self.assertRaises(ValueError):
            simgap.write_table({"a": [1.0], "b": [1.0, 2.0]})

    def test_arrays_are_fitted_as_a_file_is(self):
        log = SOURCE / "data/logs/shock-cord.csv.gz"
        of_file, of_arrays = simgap.run("fit-spring", log), simgap.run("fit-spring", simgap.read_table(log))
        self.assertEqual(of_file.json["parameters"], of_arrays.json["parameters"])
        names, values, deviations = of_file.parameters
        self.assertEqual(values[list(names).index("stiffness")], of_file.value("stiffness"))
        self.assertTrue((deviations > 0.0).all())
        self.assertTrue(of_file.report.exists())
        self.assertEqual(of_file.table("errors.csv")["error_N"].dtype, float)

    def test_failures_carry_their_code_and_sentence(self):
        with self.assertRaises(simgap.Error) as caught:
            simgap.run("fit-spring", {"deflection_m": numpy.zeros(3)})
        self.assertEqual(caught.exception.code, 3)
        self.assertIn("force", str(caught.exception))
        with self.assertRaises(KeyError):
            simgap.run("fit-spring", SOURCE / "data/logs/shock-cord.csv.gz").value("stifness")

    def test_equilibria_are_those_that_validate_judges(self):
        arm, poses = SOURCE / "data/arm/arm.yaml", SOURCE / "data/arm/poses_validation.csv"
        names, rotations = simgap.equilibria(arm, simgap.read_table(poses))
        measured = simgap.read_table(poses)
        judged = {pose["pose"]: pose["error_deg"] for pose in simgap.run("validate", arm, poses=poses, evaluator="equilibrium").json["poses"]}
        self.assertGreater(len(names), 5)
        elbows = numpy.degrees(2.0 * numpy.arccos(numpy.clip(rotations["forearm"][:, 0], -1.0, 1.0)))
        for name, elbow in zip(names, elbows):
            row = list(measured["pose"]).index(name)
            self.assertAlmostEqual(abs(elbow - numpy.degrees(measured["elbow_rad"][row])), judged[name]["elbow"], delta=0.01)

    def test_the_example_runs(self):
        done = subprocess.run([sys.executable, SOURCE / "python/example.py"], cwd=SOURCE, capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(SOURCE / "python")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"stiffness 1(49|50)\.\d ± 0\.\d N/m\n")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
