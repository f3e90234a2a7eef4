"""Result directories of every command on small data, for the tests of pages and figures."""
import json
import math
import random
import shutil
import subprocess


def write_csv(file, header, rows):
    file.write_text(header + "\n" + "\n".join(",".join(f"{value:.9g}" for value in row) for row in rows) + "\n")


def friction_log(file):
    """A drive with load-dependent Stribeck friction, swept over speeds and loads."""
    noise, rows = random.Random(1), []
    for i in range(4000):
        t, load = i * 0.01, 10.0 * math.sin(0.11 * i * 0.01)
        velocity = 30.0 * math.sin(0.7 * t) * math.sin(0.05 * t + 0.5)
        dry = 0.3 + 0.05 * abs(load) + 0.2 * math.exp(-(abs(velocity) / 3.0) ** 1.2)
        friction = math.copysign(dry, velocity) + 0.02 * velocity
        rows.append((t, (load + friction) / 1.3 + noise.gauss(0, 0.02), velocity, load, i // 1000))
    write_csv(file, "time_s,motor_current_A,motor_velocity_rad_s,external_torque_Nm,session", rows)


def motor_log(file):
    """A DC motor that steps through voltages, by the equations of its coil and rotor."""
    noise, rows, current, velocity, dt = random.Random(2), [], 0.0, 0.0, 1e-4
    for i in range(20000):
        voltage = (0.0, 4.0, 9.0, -6.0, 2.0)[i // 4000]
        current += dt / 3e-4 * (voltage - 0.8 * current - 0.011 * velocity)
        torque = 0.011 * current - 1e-6 * velocity - math.copysign(min(0.002, abs(0.011 * current) if velocity == 0 else 0.002), velocity or current)
        velocity += dt / 2e-6 * torque
        if i % 20 == 0:
            rows.append((i * dt, voltage, current + noise.gauss(0, 0.01), velocity + noise.gauss(0, 0.5)))
    write_csv(file, "time_s,voltage_V,current_A,velocity_rad_s", rows)


def muscle_log(file):
    """Forces of a pneumatic muscle with a = 1.2e-3, b = -2.4e-3, c = 1e-4 m2 over pressure and contraction."""
    noise, rows = random.Random(3), []
    for p in range(1, 7):
        for k in range(40):
            pressure, e = 1e5 * p, 0.25 * k / 40
            rows.append((pressure, e, pressure * (1.2e-3 - 2.4e-3 * e + 1e-4 * e * e) + noise.gauss(0, 1.0)))
    write_csv(file, "pressure_Pa,contraction,force_N", rows)


def spring_log(file):
    """A cord of 150 N/m that hangs loose below 10 mm, pulled and released."""
    noise, rows = random.Random(4), []
    for i in range(3000):
        t = 0.02 * i
        x = 0.02 + 0.03 * math.sin(0.5 * t) * math.sin(0.06 * t + 0.3)
        rows.append((t, x, 150.0 * max(x - 0.01, 0.0) + noise.gauss(0, 0.03)))
    write_csv(file, "time_s,deflection_m,force_N", rows)


def boards(source, folder):
    """The first ten pairs of data/boards, as few as a calibration takes: looking for the board is what takes its time."""
    for side in ("left", "right"):
        (folder / "boards" / side).mkdir(parents=True, exist_ok=True)
        for picture in sorted((source / "data/boards" / side).iterdir())[:10]:
            shutil.copy(picture, folder / "boards" / side)


def commands(source, folder):
    """Result directory -> arguments of the command that fills it, in an order in which they can run."""
    arm, capture, exo, robot = (source / "data" / name for name in ("arm", "capture", "exoskeleton", "robot"))
    friction_log(folder / "friction.csv")
    motor_log(folder / "motor.csv")
    muscle_log(folder / "muscle.csv")
    spring_log(folder / "spring.csv")
    boards(source, folder)
    poses = ["--poses", arm / "poses_calibration.csv"]
    return {
        "calibrate": ["calibrate", arm / "arm.yaml", *poses, "--validation", arm / "poses_validation.csv", "--optimizer", "lm", "--starts", "2"],
        "validate": ["validate", folder / "calibrate/model.yaml", "--poses", arm / "poses_validation.csv"],
        "design": ["design", arm / "arm.yaml", *poses, "--count", "2", "--candidates", "20"],
        "capture": ["capture", capture / "rig.yaml", "--left", capture / "left", "--right", capture / "right", "--timestamps",
                    capture / "timestamps.csv", "--shafts", capture / "shafts.csv", "--overlay", "0"],
        "calibrate-cameras": ["calibrate-cameras", folder / "boards/left", folder / "boards/right", "--board", "chessboard:9x6:0.025"],
        "calibrate-joints": ["calibrate-joints", capture / "rig.yaml", "--frames", folder / "capture/frames.csv"],
        "targets-check": ["targets", "check", capture / "targets.yaml"],
        "fit-friction": ["fit-friction", folder / "friction.csv", "--ratio", "1", "--require", "fast:900:12"],
        "fit-motor": ["fit-motor", folder / "motor.csv"],
        "fit-gearbox": ["fit-gearbox", source / "data/logs/gearbox.csv.gz", "--motor", folder / "fit-motor/model.yaml", "--ratio", "72"],
        "fit-pam": ["fit-pam", folder / "muscle.csv"],
        "fit-spring": ["fit-spring", folder / "spring.csv"],
        "diagnose-poses": ["diagnose", source / "data/arm-dense/arm.yaml", "--poses", source / "data/arm-dense/poses_calibration.csv",
                           "--effects", "spindle-coiling"],
        "predict": ["predict", folder / "fit-friction/model.yaml", folder / "friction.csv"],
        "exo-joint": ["simulate", exo / "joint.yaml", "--commands", exo / "torque.yaml"],
        "cable-drive": ["simulate", source / "data/cable-drive/drive.yaml", "--commands", source / "data/cable-drive/path.yaml"],
        "fit-dynamics": ["fit-dynamics", robot / "robot.urdf", "--log", robot / "log.csv.gz"],
        "diagnose-robot": ["diagnose", folder / "fit-dynamics/model.yaml", "--log", robot / "other_log.csv.gz"],
    }


def diagnosis(folder):
    """A diagnosis as the contract describes it; what it says is invented, so that every part of a page is there."""
    folder.mkdir(exist_ok=True)
    gain = lambda value: {"gain_heldout_percent": value, "gain_ci95": [value - 3.0, value + 3.0], "p_adjusted": 1e-4}
    causes = [
        {"effect": "friction-heating", "sentence": "Friction falls as the drive warms up.", "ambiguous_with": [], **gain(21.0),
         "parameters": [{"name": "beta", "unit": "1_K", "value": 0.012, "ci95": [0.010, 0.014]}], "absorbed_by": [{"parameter": "k_v", "shift_sd": -4.2}]},
        {"effect": "muscle-wrap", "target": "biceps", "sentence": "The muscle bends round a bone.", "ambiguous_with": ["cord-creep"], **gain(8.0),
         "parameters": [{"name": "radius", "unit": "m", "value": 0.05, "ci95": [0.04, 0.06]}], "absorbed_by": []}]
    result = {
        "format": "simgap/diagnose/1", "verdict": "ambiguous", "sentence": "Friction falls as the drive warms up, and a muscle bends round a bone.",
        "causes": causes, "baseline": {"mse": 0.010, "mse_heldout": 0.012, "noise_floor": 0.004}, "extended": {"mse": 0.006, "mse_heldout": 0.007},
        "error_unit": "A2", "n": 6000, "n_effective": 900.0, "explainable_percent": 50.0, "explained_percent": 41.0,
        "left_over": {"share_percent": 3.0, "channels": [{"channel": "time_s", "share_percent": 3.0, "shape": ""}]}, "candidates": [], "not_testable": [{"effect": "torque-constant-heating", "reason": "needs temperature_degC"}],
        "detectable": [{"effect": "inertia", "target": "", "parameter": "J", "unit": "kg_m2", "magnitude95": 1e-5}],
        "faults": [{"channel": "current", "sentence": "Rows 10 to 12 are spikes.", "first_row": 10, "last_row": 12, "rows": 3, "corrected": True}],
        "next_experiment": "Let the drive cool down again while it moves.", "warnings": [],
        "self_test": {"hidden": ["none", "inertia"], "answers": ["nothing", "inertia", "other"], "count": [[19, 0, 1], [2, 18, 0]],
                      "false_alarm_rate": 0.05, "power": 0.9}}
    (folder / "result.json").write_text(json.dumps(result))
    (folder / "run.json").write_text(json.dumps({
        "format": "simgap/run/1", "version": "0", "git_hash": "none", "argv": ["simgap", "diagnose"], "seed": 1, "start": "2026-01-01T00:00:00Z",
        "duration_s": 1.0, "status": "done", "inputs": []}))
    bins = [(against, c, 0.1 * math.sin(c), 0.02, 0.01 * math.cos(c), 0.02, 50, "") for against in ("temperature_degC", "load_Nm") for c in range(12)]
    (folder / "evidence.csv").write_text("against,center,before,before_ci95,after,after_ci95,rows,unit\n" + "".join(",".join(map(str, b)) + "\n" for b in bins))
    times = [(0.1 * i, math.sin(0.1 * i), 1.2 * math.sin(0.1 * i), 1.02 * math.sin(0.1 * i), 1) for i in range(500)]
    (folder / "predictions.csv").write_text("time_s,measured,before,after,used\n" + "".join(",".join(map(str, t)) + "\n" for t in times))
    (folder / "hypotheses.csv").write_text(
        "step,effect,target,gain_percent,gain_lower95_percent,gain_upper95_percent,p_adjusted,outcome\n"
        "1,friction-heating,,20.5,18,23,0.0001,accepted\n1,inertia,,0.2,-0.5,0.9,0.4,rejected: no gain\n2,muscle-wrap,biceps,8,5,11,0.0001,ambiguous\n")


def make(simgap, source, folder, names=None):
    """Runs the commands that fill `names` (of commands(); default: all of them), and makes the diagnosis. Returns the names."""
    folder.mkdir(parents=True, exist_ok=True)
    runs = commands(source, folder)
    for name in runs if names is None else [name for name in runs if name in names]:
        run(name, [simgap, *runs[name], "-q", "--force", "-o", folder / name])
    diagnosis(folder / "diagnose")
    run("diagnose", [simgap, "report", folder / "diagnose"])
    return [*runs, "diagnose"] if names is None else names


def run(name, command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{name}: {done.stderr}")
