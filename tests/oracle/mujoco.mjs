// MuJoCo (npm's mujoco-js, the official WebAssembly) says what an MJCF model is.
//
//   node mujoco.mjs request.json     one line of JSON per answer; without a request: whether there is a MuJoCo
//
// Request: {"xml": "...", "folder": "where its includes are", "positions": [[qpos ...], ...], "settle": {...}}.
// First answer: {"joints": [{name, type, qposadr}], "tendons": [...], "bodies": [...], "mass": [...], "steps_per_s"?}.
// Then per position {"length": [...], "arm": [[d length / d dof ...], ...], "position": [[x, y, z], ...]}.
// "settle": {"seconds": 60, "controls": [[...], ...], "starts": [[qpos ...], ...]}: per row of controls (one empty row
// without any) where the model comes to rest: {"qpos": [...], "speed": largest joint velocity left}.
// "time_steps": N: processor time of a step from the model's zero position on, "step_us", and the step, "timestep_s".
import fs from 'node:fs';
import path from 'node:path';
import load from 'mujoco-js';

const mujoco = await load();
if (process.argv.length < 3) {
  console.log(JSON.stringify({ version: mujoco.mj_versionString() }));
  process.exit(0);
}
const request = JSON.parse(fs.readFileSync(process.argv[2], 'utf8'));
mujoco.FS.mkdir('/model');
for (const name of request.folder ? fs.readdirSync(request.folder) : []) {
  const file = path.join(request.folder, name);
  if (fs.statSync(file).isFile()) mujoco.FS.writeFile('/model/' + name, fs.readFileSync(file));
}
mujoco.FS.writeFile('/model/__request__.xml', request.xml);
const model = mujoco.MjModel.loadFromXML('/model/__request__.xml');
const data = new mujoco.MjData(model);
const print = (answer) => console.log(JSON.stringify(answer));
const names = (count, type) =>
  Array.from({ length: count }, (_, i) => mujoco.mj_id2name(model, type.value ?? type, i));
const OBJ = mujoco.mjtObj;

const jointNames = names(model.njnt, OBJ.mjOBJ_JOINT);
const first = {
  joints: jointNames.map((name, i) => ({ name, type: model.jnt_type[i], qposadr: model.jnt_qposadr[i],
    dofadr: model.jnt_dofadr[i] })),
  tendons: names(model.ntendon, OBJ.mjOBJ_TENDON),
  bodies: names(model.nbody, OBJ.mjOBJ_BODY),
  mass: Array.from(model.body_mass),
};
if (request.time_steps) {
  for (let i = 0; i < 1000; ++i) mujoco.mj_step(model, data); // until it is compiled
  const start = process.cpuUsage();
  for (let i = 0; i < request.time_steps; ++i) mujoco.mj_step(model, data);
  first.step_us = process.cpuUsage(start).user / request.time_steps;
  first.timestep_s = model.opt.timestep;
  mujoco.mj_resetData(model, data);
}
print(first);

// d length / d dof; rows are stored in full in models of few joints.
function arms() {
  const full = model.nv < 60;
  const rows = [];
  for (let t = 0; t < model.ntendon; ++t) {
    const row = full ? Array.from(data.ten_J.slice(t * model.nv, (t + 1) * model.nv)) : new Array(model.nv).fill(0);
    for (let k = 0; !full && k < data.ten_J_rownnz[t]; ++k) {
      const at = data.ten_J_rowadr[t] + k;
      row[data.ten_J_colind[at]] = data.ten_J[at];
    }
    rows.push(row);
  }
  return rows;
}

for (const qpos of request.positions ?? []) {
  data.qpos.set(qpos);
  mujoco.mj_forward(model, data);
  const places = [];
  for (let b = 0; b < model.nbody; ++b) places.push(Array.from(data.xpos.slice(3 * b, 3 * b + 3)));
  print({ length: Array.from(data.ten_length), arm: arms(), position: places });
}

// Rest: time is let pass until nothing moves.
if (request.settle) {
  const controls = request.settle.controls ?? [[]];
  for (const [k, control] of controls.entries()) {
    mujoco.mj_resetData(model, data);
    if (request.settle.starts) data.qpos.set(request.settle.starts[k]);
    data.ctrl.set(control);
    const speed = () => data.qvel.reduce((most, v) => Math.max(most, Math.abs(v)), 0);
    const steps = request.settle.seconds / model.opt.timestep;
    for (let i = 0, still = 0; i < steps && still < 1000; ++i) {
      mujoco.mj_step(model, data);
      still = speed() < 1e-9 ? still + 1 : 0;
    }
    print({ qpos: Array.from(data.qpos), speed: speed() });
  }
}
