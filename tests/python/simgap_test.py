#!/usr/bin/python3
"""The Python module on the program itself; skipped where python3-numpy is missing.

    tests/python/simgap_test.py SIMGAP SOURCE [FOLDER OF _simgap]
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
sys.path += sys.argv[3:]
import simgap  # noqa: E402

ARM = SOURCE / "data/arm/arm.yaml"
POSES = SOURCE / "data/arm/poses_validation.csv"


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


@unittest.skipUnless(len(sys.argv) > 3, "_simgap was not built")
class Compiled(unittest.TestCase):
    def test_an_arm_says_what_its_file_says(self):
        arm = simgap.Arm(str(ARM))
        self.assertEqual(arm.bodies, ["torso", "humerus", "forearm"])
        self.assertEqual(arm.joints, ["shoulder", "elbow"])
        self.assertEqual(len(arm.muscles), 11)
        poses, table = arm.read_poses(str(POSES)), simgap.read_table(POSES)
        self.assertEqual(poses["names"], [str(name) for name in table["pose"]])
        for m, muscle in enumerate(arm.muscles):
            self.assertEqual(poses["shafts"][:, m].tolist(), table[f"shaft_{muscle}_rad"].tolist())
        self.assertEqual(poses["joints"]["elbow"].tolist(), table["elbow_rad"].tolist())
        self.assertEqual(poses["joints"]["shoulder"].shape, (len(poses["names"]), 4))

    def test_equilibria_and_simulated_poses_are_those_of_validate(self):
        arm = simgap.Arm(str(ARM))
        shafts = arm.read_poses(str(POSES))["shafts"][:4]
        few = {name: values[:4] for name, values in simgap.read_table(POSES).items()}
        for evaluator in ("equilibrium", "bullet"):
            found = arm.rest(shafts, evaluator=evaluator)
            self.assertEqual(found["status"], ["steady"] * 4)
            frames = simgap.frames(simgap.run("validate", ARM, poses=few, evaluator=evaluator))
            for b, body in enumerate(arm.bodies):
                numpy.testing.assert_allclose(found["origins"][:, b], frames[body][:, :3], atol=1e-9)
                turned = numpy.abs(numpy.sum(found["rotations"][:, b] * frames[body][:, 3:], axis=1))
                numpy.testing.assert_allclose(turned, 1.0, atol=1e-9)

    def test_shafts_of_another_shape_or_without_numbers_are_refused(self):
        arm = simgap.Arm(str(ARM))
        shafts = arm.read_poses(str(POSES))["shafts"][:2].copy()
        found = arm.rest(shafts[:0])
        self.assertEqual(found["origins"].shape, (0, 3, 3))
        with self.assertRaisesRegex(ValueError, "expected \\(poses, 11\\)"):
            arm.rest(shafts[:, :3])
        shafts[1, 2] = numpy.nan
        with self.assertRaisesRegex(ValueError, "shaft of pose 1 that is no finite number"):
            arm.rest(shafts)

    def test_fits_are_those_of_the_program(self):
        log = simgap.read_table(SOURCE / "data/logs/shock-cord.csv.gz")
        run, fit = simgap.run("fit-spring", log), simgap.fit_spring(log, cord=True)
        self.assertEqual(run.parameter("rest_length")["name"], "rest_length")  # the program has chosen the cord, too
        names, values, deviations = run.parameters
        self.assertEqual(fit["names"], names.tolist())
        numpy.testing.assert_allclose(fit["values"], values, rtol=1e-9)
        numpy.testing.assert_allclose(fit["sd"], deviations, rtol=1e-9)
        numpy.testing.assert_allclose(numpy.sqrt(numpy.diag(fit["covariance"])), deviations, rtol=1e-6)

        motor = simgap.read_table(SOURCE / "data/logs/motor.csv.gz")
        run, fit = simgap.run("fit-motor", motor), simgap.fit_motor(motor)
        for name in ("R", "K_T", "J_M"):
            self.assertAlmostEqual(fit["values"][fit["names"].index(name)] / run.value(name), 1.0, places=9)

        muscle = simgap.read_table(SOURCE / "data/logs/muscle.csv.gz")
        run, fit = simgap.run("fit-pam", muscle), simgap.fit_pam(muscle)
        self.assertAlmostEqual(fit["values"][fit["names"].index("k")] / run.value("k"), 1.0, places=9)

        drive = {name: values[:4000] for name, values in simgap.read_table(SOURCE / "data/logs/none.csv.gz").items()}
        run, fit = simgap.run("fit-friction", drive, model="classic"), simgap.fit_friction(drive, law="classic")
        self.assertAlmostEqual(fit["values"][fit["names"].index("k_a")] / run.value("k_a"), 1.0, places=9)

    def test_failures_carry_their_code_and_sentence(self):
        with self.assertRaises(simgap.LibraryError) as caught:
            simgap.fit_spring({"deflection_m": numpy.zeros(3)})
        self.assertEqual(caught.exception.code, 3)
        self.assertIn("force", str(caught.exception))
        with self.assertRaises(simgap.LibraryError) as caught:
            simgap.Arm("nowhere.yaml")
        self.assertEqual(caught.exception.code, 2)
        with self.assertRaisesRegex(ValueError, "force_N: found 2 rows, expected the 3 of deflection_m"):
            simgap.fit_spring({"deflection_m": numpy.zeros(3), "force_N": numpy.zeros(2)})

    def test_the_example_runs(self):
        done = subprocess.run([sys.executable, SOURCE / "python/example_arrays.py"], cwd=SOURCE, capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": f"{SOURCE / 'python'}:{sys.argv[3]}"})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"the elbow bends from 36 to 4\d deg, its place moves \d+ mm\n")
        self.assertRegex(done.stdout, r"4 of 4 came to rest, within \d\.\d deg\n(1[6-9]|20) of 20 intervals")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
