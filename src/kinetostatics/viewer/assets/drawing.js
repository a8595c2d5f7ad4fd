/* Drawing of a robot. All objects of three.js are in meshcat's scene tree, so the check boxes of this tree apply to them. */

const vector = new THREE.Vector3(), other = new THREE.Vector3();
const BEHIND = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8 }; // hidden where surfaces coincide

class Robot {
  /** `root`: start of all its paths in the tree. */
  constructor(description, root = "") {
    this.root = root;
    this.solids = new Map(); // path -> {spec, mesh, rigid, atRest, byQuantity}
    this.arrows = new Map(); // path -> {spec, object, tip, size, value}
    this.frames = new Map(); // path -> {spec, object}
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.007 * description.size, 12, 8), new THREE.MeshBasicMaterial({ color: description.mark, depthTest: false, transparent: true }));
    this.mark = { object: this.put("Marks/largest", new THREE.Group()), text: "" };
    this.mark.object.add(ball);
    addLabel(this, this.mark.object, () => this.mark.text, "#b0005e", "mark", () => this.mark.object.seen);
    this.load(description);
  }

  /** Load a description, or its changes. Present objects are updated in place, so camera and check boxes remain. */
  load(description) {
    const { meshes = [], frames = [], arrows = [], labels: marks = [] } = read(description);
    this.scene = { ...this.scene, ...description };
    meshes.forEach((spec) => spec.roots.forEach((root) => this.addSolid(`${root}/${spec.path}`, spec, root)));
    frames.forEach((spec) => this.addFrame(spec));
    arrows.forEach((spec) => this.addArrow(spec));
    marks.forEach((spec) => this.addFrame(spec));
    const present = new Set(this.scene.arrows.map((spec) => spec.path));
    for (const [path, entry] of this.arrows) entry.gone = !present.has(path);
  }

  /** Draw the robot at the present time, with the colours of a scale. */
  draw(scale) {
    this.now = solve(this.scene);
    this.most = { value: 0 };
    for (const solid of this.solids.values()) this.placeSolid(solid, scale);
    this.placeMost(scale);
    for (const arrow of this.arrows.values()) this.placeArrow(arrow);
    for (const { spec, object } of this.frames.values()) {
      object.position.fromArray(this.now.deformed, 7 * spec.station);
      object.quaternion.fromArray(this.now.deformed, 7 * spec.station + 3);
    }
  }

  /** Make it a ghost of one colour, without labels, arrows and the pale robot at rest; or solid again. */
  setGhost(ghost) {
    for (const solid of this.solids.values()) {
      solid.look = solid.look || solid.mesh.material;
      solid.mesh.material = ghost ? GHOST : solid.look;
    }
    for (const name of PARTS) {
      const gone = ghost && name !== "Deformed" && !(name === "Base" && !sameBase(this, page.robots[0]));
      this.node(name).visible = !gone;
    }
  }

  /** Remove it from the picture; check boxes remain as they are. */
  remove() {
    for (const name of PARTS) {
      const path = [...this.root.split("/").filter(Boolean), name];
      for (const child of Object.keys(viewer.scene_tree.find(path).children)) viewer.delete_path([...path, child]);
    }
    for (const { element, leader } of labels.filter(({ robot }) => robot === this)) for (const item of [element, leader]) item.remove();
    labels.splice(0, labels.length, ...labels.filter(({ robot }) => robot !== this));
  }

  /** Its top objects in meshcat's tree. */
  nodes() {
    return PARTS.map((name) => this.node(name));
  }

  node(name) {
    return viewer.scene_tree.find([...this.root.split("/").filter(Boolean), name]).object;
  }

  put(path, object) {
    viewer.set_object((this.root + path).split("/"), object);
    return object;
  }

  // -------------------------------------------------------------- surfaces

  addSolid(path, spec, root) {
    const rigid = typeof spec.station === "number", atRest = root !== "Deformed", pale = root === "Rest";
    const byQuantity = spec.colour === "deflection" && !atRest, old = this.solids.get(path);
    if (old && old.rigid === rigid && old.spec.faces.length === spec.faces.length && old.spec.vertices.length === spec.vertices.length) {
      const { geometry } = old.mesh; // an update of the same object
      old.spec = spec;
      geometry.attributes.position.copyArray(spec.vertices).needsUpdate = true;
      geometry.setIndex(new THREE.BufferAttribute(spec.faces, 1));
      geometry.computeVertexNormals();
      geometry.boundingBox = geometry.boundingSphere = null;
      return;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(spec.vertices.slice(), 3));
    geometry.setIndex(new THREE.BufferAttribute(spec.faces, 1));
    const vertexColours = byQuantity || (spec.per_vertex && !pale);
    if (vertexColours) {
      const colours = byQuantity ? new Float32Array(spec.vertices.length) : spec.colour;
      geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    }
    geometry.computeVertexNormals();
    const { resting } = this.scene;
    const material = pale
      ? new THREE.MeshPhongMaterial({ color: resting.colour, transparent: true, opacity: resting.opacity, depthWrite: false, shininess: 5, ...BEHIND })
      : new THREE.MeshPhongMaterial({
        color: vertexColours ? 0xffffff : spec.colour === "deflection" ? this.scene.unknown : spec.colour, vertexColors: vertexColours,
        side: THREE.DoubleSide, shininess: 12, specular: 0x222222,
      });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false; // its bounding sphere would be that of the first frame
    this.put(path, mesh);
    this.solids.set(path, { spec, mesh, rigid, atRest, byQuantity });
  }

  placeSolid(solid, scale) {
    const { spec, mesh, rigid, atRest, byQuantity } = solid;
    const poses = atRest || spec.recovery ? this.now.rest : this.now.deformed, n = spec.vertices.length / 3;
    if (rigid) {
      mesh.position.fromArray(poses, 7 * spec.station);
      mesh.quaternion.fromArray(poses, 7 * spec.station + 3);
    } else {
      const position = mesh.geometry.attributes.position;
      for (let v = 0; v < n; v++) {
        const o = 7 * spec.station[v];
        point.fromArray(spec.vertices, 3 * v).applyQuaternion(qa.fromArray(poses, o + 3));
        position.setXYZ(v, point.x + poses[o], point.y + poses[o + 1], point.z + poses[o + 2]);
      }
      if (spec.recovery && !atRest) recovered(this.now, spec).forEach((u, k) => { position.array[k] += state.exaggeration * swing() * u; });
      position.needsUpdate = true;
      mesh.geometry.computeVertexNormals();
      mesh.geometry.boundingSphere = null; // for clicks
    }
    if (byQuantity) this.colourSolid(solid, scale);
  }

  /** Colour every vertex by the quantity of the page, and find its largest value. */
  colourSolid(solid, scale) {
    const colour = solid.mesh.geometry.attributes.color, value = valuesOf(this, solid, scale.key), n = solid.spec.vertices.length / 3;
    for (let v = 0; v < n; v++) {
      const x = value(v);
      setColour(colour, v, x, scale);
      if (Math.abs(x) > Math.abs(this.most.value)) this.most = { value: x, solid, v };
    }
    colour.needsUpdate = true;
  }

  /** Place the mark at the largest value. */
  placeMost(scale) {
    const { value, solid, v } = this.most, { object } = this.mark;
    object.seen = object.children[0].visible = value !== 0 && !scale.rigid && !state.mode;
    this.mark.text = `largest ${number(value / scale.factor)} ${scale.unit}`;
    if (!object.seen) return;
    point.fromBufferAttribute(solid.mesh.geometry.attributes.position, v);
    object.position.copy(solid.rigid ? point.applyQuaternion(solid.mesh.quaternion).add(solid.mesh.position) : point);
  }

  /** The largest true displacement of vertices of beams, and of corners of bounding boxes of rigid links, at the present time [m]. */
  largestDisplacement() {
    this.now = solve(this.scene);
    let most = 0;
    for (const solid of this.solids.values()) {
      if (!solid.byQuantity) continue;
      let { vertices } = solid.spec;
      if (solid.rigid) {
        if (!solid.mesh.geometry.boundingBox) solid.mesh.geometry.computeBoundingBox();
        const { min, max } = solid.mesh.geometry.boundingBox;
        vertices = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((k) => [k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z]);
      }
      const value = valuesOf(this, { spec: { ...solid.spec, vertices }, rigid: solid.rigid }, "deflection");
      for (let v = 0; v < vertices.length / 3; v++) most = Math.max(most, value(v));
    }
    return most;
  }

  // -------------------------------------------------------------- arrows, frames and marks

  addArrow(spec) {
    const old = this.arrows.get(spec.path);
    if (old) { old.spec = spec; return; }
    const object = this.put(spec.path, makeArrow(spec.colour, spec.radius, spec.kind === "moment" ? 2 : 1));
    const entry = { spec, object, tip: new THREE.Object3D(), size: 0, value: 0 };
    object.add(entry.tip);
    this.arrows.set(spec.path, entry);
    addLabel(this, entry.tip, () => entry.spec.unit ? `${entry.spec.label}\n${number(entry.value)} ${entry.spec.unit}` : entry.spec.label, spec.colour, "arrow", () => object.seen, spec.path);
  }

  /** The sum of parts (frames, width, 3) of a vector with weights(k), at the present time. */
  blend(data, width, weights, out) {
    const [i, j, w] = between(this.scene);
    out.set(0, 0, 0);
    for (let k = 0; k < width; k++) {
      for (const [frame, share] of [[i, (1 - w) * weights(k)], [j, w * weights(k)]]) {
        const o = 3 * (frame * width + k);
        out.x += share * data[o]; out.y += share * data[o + 1]; out.z += share * data[o + 2];
      }
    }
    return out;
  }

  placeArrow(entry) {
    const { spec, object } = entry, K = this.scene.contributions.length, part = shares(this.scene), { deformed } = this.now;
    this.blend(spec.vector, K + 1, (k) => (k < K ? part[k] : 1), vector);
    entry.size = entry.gone ? 0 : vector.length();
    entry.value = entry.size;
    if (spec.positive && this.blend(spec.positive, 1, () => 1, other).dot(vector) < 0) entry.value = -entry.size;
    const against = () => this.blend(spec.outward, 1, () => 1, other).dot(vector) < -0.1 * other.length() * entry.size;
    const inwards = spec.anchor === "tip" || (spec.outward && against());
    const length = entry.size * spec.metres_per_unit, o = 7 * spec.station;
    object.stretch(length);
    if (entry.size > 0) object.quaternion.setFromUnitVectors(UP, vector.normalize());
    point.fromArray(spec.offset).applyQuaternion(qa.fromArray(deformed, o + 3));
    object.position.fromArray(deformed, o).add(point);
    if (inwards) object.position.addScaledVector(vector, -length);
    entry.tip.position.set(0, inwards ? 0 : length, 0); // the label is at the free end
  }

  /** Add a coordinate system with axes and name; a name alone has no size. */
  addFrame(spec) {
    if (this.frames.has(spec.path)) { this.frames.get(spec.path).spec = spec; return; }
    const object = this.put(spec.path, new THREE.Group());
    if (spec.size) this.drawAxes(object, spec.size);
    this.frames.set(spec.path, { spec, object });
    addLabel(this, object, () => spec.label ?? spec.text, spec.size ? "#20262e" : "#4a5462", spec.size ? "frame" : "name");
  }

  drawAxes(object, size) {
    [["#d62728", [1, 0, 0]], ["#2ca02c", [0, 1, 0]], ["#1f77b4", [0, 0, 1]]].forEach(([colour, direction]) => {
      const part = makeArrow(colour, 0.025 * size, 1);
      part.stretch(size);
      part.quaternion.setFromUnitVectors(UP, new THREE.Vector3(...direction));
      object.add(part);
    });
    object.add(new THREE.Mesh(new THREE.SphereGeometry(0.05 * size, 16, 12), new THREE.MeshPhongMaterial({ color: 0x20262e })));
    object.traverse((part) => { // frames are drawn over all bodies, which would hide them
      if (part.material) { part.material.depthTest = false; part.material.transparent = true; part.renderOrder = 10; }
    });
  }
}

// ---------------------------------------------------------------- arrows

const SHAFT = new THREE.CylinderGeometry(1, 1, 1, 14).translate(0, 0.5, 0); // along y, from the origin
const HEAD = new THREE.ConeGeometry(1, 1, 18).translate(0, -0.5, 0); // its tip at the origin
const UP = new THREE.Vector3(0, 1, 0);

/** An arrow along y with one head, or two for a moment; `stretch(length)` sets its length, `seen` is false for zero length. */
function makeArrow(colour, radius, heads) {
  const group = new THREE.Group();
  const material = new THREE.MeshPhongMaterial({ color: colour, shininess: 12 });
  const hidden = new THREE.MeshBasicMaterial({ // the part inside the robot shows through
    color: colour, transparent: true, opacity: 0.28, depthFunc: THREE.GreaterDepth, depthWrite: false,
  });
  const part = (geometry) => {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.add(new THREE.Mesh(geometry, hidden));
    group.add(mesh);
    return mesh;
  };
  const shaft = part(SHAFT), cones = Array.from({ length: heads }, () => part(HEAD));
  group.stretch = (length) => {
    group.seen = length > 0.2 * radius;
    for (const mesh of [shaft, ...cones]) mesh.visible = group.seen; // the group's own visibility is that of its check box
    if (!group.seen) return;
    const r = radius * Math.min(1, length / (9 * radius)), head = Math.min(6 * r, 0.6 * length / heads);
    shaft.scale.set(r, length - 0.9 * head, r);
    cones.forEach((cone, i) => {
      cone.position.y = length - 0.75 * i * head;
      cone.scale.set(2.4 * r, head, 2.4 * r);
    });
  };
  group.paint = (shade) => { for (const item of [material, hidden]) item.color.set(shade(colour)); };
  return group;
}
