'use strict';
// An arm over its poses in three dimensions (three.js): the measured pose as a ghost, the simulated one solid, muscles
// as lines whose colour and thickness grow with their tension.

/** Blue, orange, vermilion: told apart by colour-blind people and on both backgrounds. */
function tensionColour(t) {
  const stops = [cssColour('c0'), cssColour('c4'), cssColour('c1')];
  const place = Math.min(Math.max(t, 0), 1) * 2, stop = Math.min(Math.floor(place), 1);
  return mixed(stops[stop], stops[stop + 1], place - stop);
}

/** [muscle, tension, x, y, z, …] of the page's data with names. */
function unpackPaths(scene) {
  const unpacked = ([muscle, tension, ...numbers]) => {
    const points = [];
    for (let i = 0; i < numbers.length; i += 3) points.push(numbers.slice(i, i + 3));
    return {name: scene.muscles[muscle], tension, points};
  };
  for (const pose of scene.poses) {
    for (const state of Object.values(pose.states)) state.paths = (state.paths || []).map(unpacked);
  }
}

const vector = p => new THREE.Vector3(p[0], p[1], p[2]);

/** A rod between two points. */
function rod(from, to, radius, material) {
  const along = to.clone().sub(from), length = along.length();
  const mesh = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, length, 10), material);
  mesh.position.copy(from).addScaledVector(along, 0.5);
  mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  return mesh;
}

function ball(at, radius, material) {
  const mesh = new THREE.Mesh(new THREE.SphereBufferGeometry(radius, 20, 14), material);
  mesh.position.copy(at);
  return mesh;
}

/** A part of a body in the body's frame. */
function partMesh(part, material) {
  if (part.shape === 'cylinder') {
    const half = vector(part.axis).multiplyScalar(part.length / 2), centre = vector(part.position);
    return rod(centre.clone().sub(half), centre.clone().add(half), part.radius, material);
  }
  if (part.shape === 'box') {
    const mesh = new THREE.Mesh(new THREE.BoxBufferGeometry(...part.size), material);
    mesh.position.copy(vector(part.position));
    return mesh;
  }
  return ball(vector(part.position), part.radius, material);
}

/** What the pointer says of a mesh. */
function named(mesh, name) {
  mesh.userData.name = name;
  return mesh;
}

class ArmView {
  constructor(figure, scene) {
    this.figure = figure;
    this.data = scene;
    unpackPaths(scene);
    this.state = scene.states[scene.states.length - 1];
    this.pose = 0;
    this.ghost = scene.ghost !== null;
    this.box = figure.querySelector('.view');
    this.addControls();
    try {
      this.startDrawing();
    } catch (error) {  // no WebGL: the numbers remain
      this.box.textContent = 'This browser cannot draw in three dimensions; the numbers stand below.';
      this.box.style.height = 'auto';
    }
    offerNumbers(figure, 'Numbers of this pose', () => this.numbers());
    this.show();
  }

  // ------------------------------------------------------------------------------------------- controls

  addControls() {
    const controls = this.figure.querySelector('.controls'), {poses, states} = this.data;
    this.slider = element('input', {type: 'range', min: 0, max: poses.length - 1, value: 0, step: 1, 'aria-label': this.data.slider});
    this.slider.addEventListener('input', () => { this.stop(); this.pose = +this.slider.value; this.show(); });
    controls.append(element('label', {class: 'group'}, this.data.slider, this.slider));
    if (this.data.duration_s > 0) {
      this.playButton = this.button('play', () => this.playing ? this.stop() : this.play());
      controls.append(this.playButton);
    }
    this.stateButtons = states.length < 2 ? [] : states.map(state => this.button(state, () => { this.state = state; this.show(); }));
    if (states.length > 1) controls.append(element('span', {class: 'group', role: 'group', 'aria-label': 'model'}, ...this.stateButtons));
    if (this.data.ghost) {
      this.ghostButton = this.button(this.data.ghost + ' as a ghost', () => { this.ghost = !this.ghost; this.show(); });
      controls.append(this.ghostButton);
    }
    const views = [['front', [1, 0, 0]], ['side', [0, 1, 0]], ['top', [0, 0.02, 1]], ['askew', [1, 0.7, 0.35]]];
    controls.append(element('span', {class: 'group', role: 'group', 'aria-label': 'look from'},
                            ...views.map(([name, from]) => this.button(name, () => { this.lookFrom(from); this.draw(); }))));
  }

  button(text, action) {
    const made = element('button', {type: 'button'}, text);
    made.addEventListener('click', action);
    return made;
  }

  /** A movement in its own time, from where the slider stands, or from the start. */
  play() {
    const last = this.data.poses.length - 1, first = this.pose < last ? this.pose : 0;
    const begin = performance.now() - 1000 * this.data.duration_s * first / last;
    const frame = now => {
      this.pose = Math.min(last, Math.max(0, Math.floor((now - begin) / 1000 / this.data.duration_s * last)));
      this.slider.value = this.pose;
      this.show();
      if (this.pose < last) this.playing = requestAnimationFrame(frame);
      else this.stop();
    };
    this.playing = requestAnimationFrame(frame);
    this.playButton.textContent = 'stop';
  }

  stop() {
    if (!this.playing) return;
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    this.playButton.textContent = 'play';
  }

  // --------------------------------------------------------------------------------------------- drawing

  startDrawing() {
    // The buffer is kept, so that a printed page shows the arm.
    this.renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(devicePixelRatio);
    this.box.append(this.renderer.domElement);
    this.renderer.domElement.setAttribute('role', 'img');
    this.renderer.domElement.setAttribute('tabindex', 0);
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 50);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableKeys = false;  // it would listen to the whole page, and take the slider's keys
    this.controls.enableZoom = false;  // the wheel scrolls the page until the view has the focus
    this.renderer.domElement.addEventListener('focus', () => { this.controls.enableZoom = true; });
    this.renderer.domElement.addEventListener('blur', () => { this.controls.enableZoom = false; });
    this.controls.addEventListener('change', () => this.draw());
    this.renderer.domElement.addEventListener('pointerdown', () => this.renderer.domElement.focus());
    this.pointed = this.figure.querySelector('.pointed');
    this.renderer.domElement.addEventListener('pointermove', event => this.nameWhatIsThere(event));
    this.renderer.domElement.addEventListener('pointerleave', () => { this.pointed.hidden = true; });
    this.renderer.domElement.addEventListener('keydown', event => this.turnByKey(event));
    this.space = new THREE.Scene();
    this.space.add(new THREE.HemisphereLight(0xffffff, 0x999999, 0.7));
    this.sun = new THREE.DirectionalLight(0xffffff, 0.45);
    this.space.add(this.sun);
    this.content = new THREE.Group();
    this.space.add(this.content);
    this.points = this.allPoints();
    this.sphere = new THREE.Sphere().setFromPoints(this.points);
    this.torso = this.fixedFrame();
    this.floor = Math.min(...this.points.map(p => p.z));
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  /** Everything any pose shows, so that the picture stands still while the arm moves. */
  allPoints() {
    const points = [];
    for (const pose of this.data.poses) {
      // The last state and what was measured: a wild start would push the arm into a corner.
      for (const state of [pose.states[this.data.states[this.data.states.length - 1]], pose.states[this.data.ghost]]) {
        if (!state) continue;
        for (const part of this.data.parts) {
          const body = state.bodies[part.body];
          if (body) {
            const turn = new THREE.Quaternion(body[4], body[5], body[6], body[3]);
            const reach = (part.length || 0) / 2 + (part.radius || 0), axis = vector(part.axis);
            for (const end of [-reach, reach]) points.push(vector(part.position).addScaledVector(axis, end).applyQuaternion(turn).add(vector(body)));
          }
        }
        for (const path of state.paths || []) path.points.forEach(p => points.push(vector(p)));
        for (const [, ...at] of state.markers || []) points.push(vector(at));
      }
    }
    return points.length ? points : [new THREE.Vector3()];
  }

  /** The body that muscles begin at and that has no shape of its own, as the box about their points that never move. */
  fixedFrame() {
    const shaped = new Set(this.data.parts.map(part => part.body)), index = this.data.bodies.findIndex((_, i) => !shaped.has(i));
    if (index < 0) return null;
    const key = p => p.map(x => x.toFixed(3)).join(), ends = new Map();
    let states = 0;
    const last = this.data.states[this.data.states.length - 1];  // another model has its muscles elsewhere
    for (const pose of this.data.poses) {
      const state = pose.states[last];
      if (state?.paths?.length) {
        ++states;
        const seen = new Map(state.paths.flatMap(path => [path.points[0], path.points[path.points.length - 1]]).map(p => [key(p), p]));
        seen.forEach((p, k) => ends.set(k, {p, count: (ends.get(k)?.count || 0) + 1}));
      }
    }
    const still = [...ends.values()].filter(end => 2 * end.count > states).map(end => vector(end.p));
    if (states < 2 || still.length < 3) return null;
    return {name: this.data.bodies[index], box: new THREE.Box3().setFromPoints(still).expandByScalar(0.015)};
  }

  addTorso() {
    if (!this.torso) return;
    const size = this.torso.box.getSize(new THREE.Vector3());
    const mesh = new THREE.Mesh(new THREE.BoxBufferGeometry(size.x, size.y, size.z), this.material(cssColour('bone'), 0.3));
    mesh.position.copy(this.torso.box.getCenter(new THREE.Vector3()));
    this.content.add(named(mesh, this.torso.name));
  }

  /** The name of the body or muscle under the pointer. */
  nameWhatIsThere(event) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const hits = ray.intersectObject(this.content, true).map(hit => hit.object.userData.name).filter(Boolean);
    const name = hits.find(hit => this.data.muscles?.includes(hit.split(',')[0])) || hits[0];
    this.pointed.hidden = !name;
    if (!name) return;
    this.pointed.textContent = name;
    this.pointed.style.left = `${event.clientX - box.left + 14}px`;
    this.pointed.style.top = `${event.clientY - box.top + 8}px`;
  }

  /** Shows the pose of that name, where there is one. */
  showPose(name) {
    const index = this.data.poses.findIndex(pose => pose.name === name);
    if (index < 0) return;
    this.pose = index;
    this.slider.value = index;
    this.show();
    this.figure.scrollIntoView({block: 'nearest'});
  }

  /** As near as all points fit into the picture. */
  lookFrom(direction) {
    if (!this.camera) return;
    const back = vector(direction).normalize(), right = new THREE.Vector3(0, 0, 1).cross(back).normalize(), up = back.clone().cross(right);
    const height = Math.tan(this.camera.fov * Math.PI / 360), width = height * this.camera.aspect;
    const distances = this.points.map(point => {
      const p = point.clone().sub(this.sphere.center);
      return p.dot(back) + Math.max(Math.abs(p.dot(up)) / height, Math.abs(p.dot(right)) / width);
    });
    this.controls.target.copy(this.sphere.center);
    this.camera.position.copy(this.sphere.center).addScaledVector(back, 1.01 * Math.max(...distances));
    this.controls.update();
  }

  turnByKey(event) {
    const turns = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
    if (!turns) return;
    event.preventDefault();
    const offset = this.camera.position.clone().sub(this.sphere.center);
    const about = turns[0] ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(0, 0, 1).cross(offset).normalize();
    const angle = 0.12 * (turns[0] || -turns[1]);
    this.camera.position.copy(this.sphere.center).add(offset.applyAxisAngle(about, angle));
    this.controls.update();
    this.draw();
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.box;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.placed) this.lookFrom(this.data.look || [1, 0.7, 0.35]);
    this.placed = true;
    this.draw();
  }

  draw() {
    if (!this.renderer) return;
    this.sun.position.copy(this.camera.position).sub(this.sphere.center);  // it shines towards the origin
    this.renderer.render(this.space, this.camera);
  }

  material(colour, opacity = 1) {
    const ghost = opacity < 1;  // lies behind what is solid in the same place
    return new THREE.MeshLambertMaterial({color: colour, transparent: ghost, opacity, depthWrite: !ghost, polygonOffset: ghost, polygonOffsetFactor: 2, polygonOffsetUnits: 2});
  }

  addBodies(state, material) {
    state.bodies.forEach((body, index) => {
      if (!body) return;
      const frame = new THREE.Group();
      frame.position.copy(vector(body));
      frame.quaternion.set(body[4], body[5], body[6], body[3]);
      this.data.parts.filter(part => part.body === index).forEach(part => frame.add(named(partMesh(part, material), this.data.bodies[index])));
      this.content.add(frame);
    });
  }

  addPaths(state) {
    for (const path of state.paths) {
      const slack = !(path.tension > 0), t = path.tension / this.data.most_tension;
      const material = slack ? this.material(cssColour('soft'), 0.5) : this.material(tensionColour(t));
      const radius = slack ? 0.001 : 0.0016 + 0.0024 * t;
      const points = path.points.map(vector), said = path.name + (slack ? ', slack' : ', ' + shortText(path.tension) + ' N');
      points.slice(1).forEach((to, i) => this.content.add(named(rod(points[i], to, radius, material), said)));
      points.forEach(p => this.content.add(ball(p, radius * 1.8, material)));
    }
  }

  addMarkers(state) {
    for (const [group, ...at] of state.markers || []) {
      this.content.add(ball(vector(at), Math.max(this.data.marker_radius, this.sphere.radius / 40), this.material(paletteColour(group))));
    }
  }

  /** Squares of a tenth of a metre below everything. */
  addFloor() {
    const squares = Math.ceil(this.sphere.radius * 10) * 2, grid = new THREE.GridHelper(squares / 10, squares, cssColour('line'), cssColour('line'));
    grid.rotation.x = Math.PI / 2;
    grid.position.set(this.sphere.center.x, this.sphere.center.y, this.floor);
    this.content.add(grid);
  }

  show() {
    const pose = this.data.poses[this.pose], state = pose.states[this.state];
    this.stateButtons.forEach(button => button.setAttribute('aria-pressed', button.textContent === this.state));
    this.ghostButton?.setAttribute('aria-pressed', this.ghost);
    this.slider.setAttribute('aria-valuetext', pose.name);
    const said = pose.name + ': ' + (state ? state.text : this.state + ': no pose, the simulation did not come to rest');
    this.figure.querySelector('.said').textContent = said;
    const details = this.figure.querySelector('.numbers');
    if (details.open) details.dispatchEvent(new Event('toggle'));
    if (!this.renderer) return;
    this.renderer.domElement.setAttribute('aria-label', said);
    this.content.traverse(part => part.geometry?.dispose());
    this.content.children.slice().forEach(child => this.content.remove(child));
    const ghost = this.ghost && pose.states[this.data.ghost];
    if (state) {
      this.addBodies(state, this.material(cssColour('bone')));
      this.addPaths(state);
      this.addMarkers(state);
    }
    if (ghost) this.addBodies(ghost, this.material(cssColour('text'), 0.35));
    this.addTorso();
    this.addFloor();
    this.draw();
  }

  numbers() {
    const pose = this.data.poses[this.pose], rows = [];
    for (const name of [this.data.ghost, this.state]) {
      pose.states[name]?.bodies.forEach((body, i) => body && rows.push([`${this.data.bodies[i]}, ${name}`, ...body.slice(0, 3), '']));
    }
    const state = pose.states[this.state];
    state?.paths.forEach(path => path.points.forEach(p => rows.push([path.name, ...p, path.tension])));
    (state?.markers || []).forEach(([group, ...at]) => rows.push([this.data.groups[group], ...at, '']));
    return [['', 'x [m]', 'y [m]', 'z [m]', 'tension [N]'], rows];
  }

  scale() {
    if (!this.data.most_tension) return '';
    const colours = [0, 0.5, 1].map(tensionColour);
    return element('div', {class: 'scale'}, '0 N (slack: grey)', element('span', {class: 'bar', style: `background: linear-gradient(to right, ${colours})`}),
                   shortText(this.data.most_tension) + ' N of tension');
  }
}

const views = [...document.querySelectorAll('figure.scene')].map(figure => new ArmView(figure, page.scenes[figure.dataset.scene]));
const redrawViews = () => views.forEach(view => {
  view.figure.querySelector('.scale')?.remove();
  view.box.after(view.scale());
  view.show();
});
redrawers.push(redrawViews);
redrawViews();
