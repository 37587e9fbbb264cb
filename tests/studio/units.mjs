// node units.mjs CLIENT_FOLDER: parts of the client that need no browser, bundled and tested in node.
import assert from "node:assert/strict";
import { mkdtemp, rm } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, test } from "node:test";
import { pathToFileURL } from "node:url";

const client = resolve(process.argv[2] ?? "tools/studio/client");
const { build } = createRequire(join(client, "package.json"))("esbuild");
const folder = await mkdtemp(join(tmpdir(), "patinate-units-"));
after(() => rm(folder, { recursive: true }));
const modules = ["xxh64", "scene/texture_tiles", "color/lab", "color/ramp", "simulation/figure10", "session", "history/relief", "ui/keys", "color/range", "ui/numbers", "scene/picking", "simulation/way", "simulation/recorded", "capture/landmarks", "capture/mask", "capture/project", "capture/photograph_files", "build/document", "build/paths", "scene/lighting", "scene/environment", "scene/seams", "scene/picture_file"];
await build({ stdin: { contents: `${modules.map((m) => `export * from "./src/${m}";`).join("\n")}\nexport * as THREE from "three";`, resolveDir: client, loader: "ts" }, bundle: true, format: "esm", platform: "node", outfile: join(folder, "units.mjs"), logLevel: "warning" });
const u = await import(pathToFileURL(join(folder, "units.mjs")).href);

const kRounding = 1e-9;

function random(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

test("xxh64 gives the published values of the reference implementation", () => {
  const of = (text) => u.xxh64(new TextEncoder().encode(text));
  assert.equal(of(""), "ef46db3751d8e999");
  assert.equal(of("a"), "d24ec4f1a98c6e5b");
  assert.equal(of("abc"), "44bc2cf5ad770999");
  assert.equal(of("Nobody inspects the spammish repetition"), "fbcea83c8a378bf1");
});

test("merged tiles cover every tile, with few rectangles", () => {
  const next = random(7);
  for (const share of [0.002, 0.02, 0.1, 0.5, 1]) {
    const columns = 128, rows = 128;
    const tiles = [];
    for (let t = 0; t < columns * rows; ++t) if (next() < share) tiles.push(t);
    const rects = u.merge_tiles(new Uint32Array(tiles), columns);
    const covered = new Set();
    for (const r of rects) {
      assert.ok(r.x >= 0 && r.y >= 0 && r.x + r.width <= columns && r.y + r.height <= rows);
      for (let y = r.y; y < r.y + r.height; ++y) for (let x = r.x; x < r.x + r.width; ++x) covered.add(y * columns + x);
    }
    for (const t of tiles) assert.ok(covered.has(t), `tile ${t} at share ${share}`);
    assert.ok(rects.length <= 128, `${rects.length} rectangles at share ${share}`);
  }
  assert.deepEqual(u.merge_tiles(new Uint32Array([5, 6, 5 + 16, 6 + 16]), 16), [{ x: 5, y: 0, width: 2, height: 2 }]);
});

test("a plane after tiles in any order equals the plane they were cut from, also where tiles stand over the edge", () => {
  const width = 20, height = 13, side = 8, columns = 3, rows = 2;
  const next = random(3);
  const truth = Uint8Array.from({ length: width * height * 4 }, () => 256 * next());
  const order = [3, 0, 5, 1, 4, 2];
  const message = new ArrayBuffer(4 * order.length + order.length * side * side * 4);
  new Uint32Array(message, 0, order.length).set(order);
  const texels = new Uint8Array(message, 4 * order.length);
  order.forEach((tile, i) => {
    for (let y = 0; y < side; ++y) for (let x = 0; x < side; ++x) for (let c = 0; c < 4; ++c) {
      const tx = (tile % columns) * side + x, ty = Math.floor(tile / columns) * side + y;
      texels[((i * side + y) * side + x) * 4 + c] = tx < width && ty < height ? truth[(ty * width + tx) * 4 + c] : 99;
    }
  });
  assert.equal(columns * rows, order.length);
  const plane = new u.TilePlane(width, height, 4, true, () => {});
  plane.apply(message, 0, order.length, side);
  assert.deepEqual(plane.data, truth);
});

test("CIEDE2000 gives the values of Sharma's table", () => {
  for (const [a, b, expected] of [[[50, 2.6772, -79.7751], [50, 0, -82.7485], 2.0425], [[50, 2.5, 0], [73, 25, -18], 27.1492], [[2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082],
    [[50, -1, 2], [50, 0, 0], 2.3669]]) {
    const kTableDigits = 5e-5;
    assert.ok(Math.abs(u.ciede2000(a, b) - expected) <= kTableDigits, `${u.ciede2000(a, b)} and not ${expected}`);
  }
});

test("Lab and back is the same color, and sRGB codes come back exactly", () => {
  for (let code = 0; code < 256; ++code) assert.equal(Math.round(255 * u.srgb_from_linear(u.linear_from_srgb(code / 255))), code);
  const kMatrixDigits = 1e-6;
  for (const color of [[0.2, 0.5, 0.8], [0, 0, 0], [1, 1, 1], [0.003, 0.9, 0.01]]) {
    u.linear_from_lab(u.lab_from_linear(color)).forEach((c, i) => assert.ok(Math.abs(c - color[i]) < kMatrixDigits));
  }
});

test("the ramp grows lighter all the way, in equal steps", () => {
  const lightness = Array.from({ length: 11 }, (_, i) => u.lab_from_linear(u.ramp_color(i / 10))[0]);
  for (let i = 1; i < lightness.length; ++i) assert.ok(lightness[i] > lightness[i - 1] + 5);
});

test("the slider of Figure 10: probabilities sum to 1, ends and thirds are as in the paper", () => {
  for (let s = 0; s <= 1; s += 0.01) {
    const b = u.behavior_of_slider(s, 0.1);
    assert.ok(Math.abs(b.bounce + b.float + b.absorb - 1) < kRounding);
  }
  assert.deepEqual(u.behavior_of_slider(0, 0), { bounce: 1, float: 0, absorb: 0, deceleration_bounce: 0, deceleration_float: 0 });
  assert.deepEqual(u.behavior_of_slider(1, 0), { bounce: 0, float: 1, absorb: 0, deceleration_bounce: 0.9, deceleration_float: 1 });
  assert.equal(u.behavior_of_slider(1 / 3, 0).bounce, 1);
});

test("a saved session answers with the nearest time, and with nothing what it does not hold", () => {
  const stored = (text) => ({ type: "text/plain", headers: { "X-Hash": text }, base64: btoa(text) });
  const session = { place: "p", responses: { "/api/texture?place=p&time=0&format=raw": stored("early"), "/api/texture?place=p&time=10.0&format=raw": stored("late"), "/api/map?place=p&name=control%3Aa": stored("map") } };
  const text = (url) => {
    const reply = u.answer_from(session, url);
    return reply && new TextDecoder().decode(reply.bytes);
  };
  assert.equal(text("/api/texture?place=p&time=10&between=blend&format=raw"), "late");
  assert.equal(text("/api/texture?place=p&time=4&format=raw"), "early");
  assert.equal(text("/api/texture?place=q&time=4&format=raw"), undefined);
  assert.equal(text("/api/map?place=p&name=control:a"), "map");
  assert.equal(text("/api/map?place=p&name=control:b"), undefined);
  assert.deepEqual(u.stored_times(session), [0, 10]);
});

test("keys have one name, whatever Shift, Caps Lock and the keyboard's letters make of them", () => {
  const pressed = (key, ...held) => u.key_of({ key, code: "KeyZ", ctrlKey: held.includes("ctrl"), metaKey: held.includes("meta"), altKey: held.includes("alt"), shiftKey: held.includes("shift") });
  assert.equal(pressed("z", "ctrl"), "ctrl+z");
  assert.equal(pressed("Z", "ctrl"), "ctrl+z");           // Caps Lock.
  assert.equal(pressed("Z", "ctrl", "shift"), "ctrl+shift+z");
  assert.equal(pressed("z", "ctrl", "shift"), "ctrl+shift+z");  // Both.
  assert.equal(pressed("z", "meta"), "ctrl+z");
  assert.equal(pressed("я", "ctrl"), "ctrl+z");
  assert.equal(pressed("F", "shift"), "shift+f");
  assert.equal(pressed("F"), "f");
  assert.equal(pressed("?", "shift"), "?");
  assert.equal(pressed("ArrowLeft"), "ArrowLeft");
});

test("a map's colors span what most of it has, and its few largest numbers do not make the rest dark", () => {
  const values = new Float32Array(1000);
  for (let i = 0; i < 500; ++i) values[i] = i % 50;  // The rest has nothing: it is not there.
  values[7] = 1000;
  const { low, high, most } = u.range_of(values);
  assert.deepEqual([low, most], [0, 1000]);
  assert.ok(high >= 47 && high <= 49, `${high}`);
  const narrow = u.range_of(Float32Array.from({ length: 101 }, (_, i) => 10 + i / 100));
  assert.ok(Math.abs(narrow.low - 10.02) < 0.011 && Math.abs(narrow.high - 10.98) < 0.011, JSON.stringify(narrow));
  const signed = u.range_of(Float32Array.from({ length: 101 }, (_, i) => i - 50));
  assert.ok(signed.low < -45 && signed.high > 45);
  assert.deepEqual(u.range_of(new Float32Array(5)), { low: 0, high: 0, least: 0, most: 0 });
  assert.equal(u.range_of(new Float32Array([NaN, Infinity, 3])).high, 3);
  const many = u.range_of(Float32Array.from({ length: 600001 }, (_, i) => i));
  assert.ok(Math.abs(many.high / 588000 - 1) < 0.001 && many.most === 600000, JSON.stringify(many));
});

test("a range is what the user says: all, without outliers, typed, by factors; and on both sides of 0 by the same steps", () => {
  const values = Float32Array.from({ length: 1001 }, (_, i) => i - 200);  // -200 to 800.
  values[0] = NaN;
  const of = (choice) => u.chosen_range(values, { ...u.kAutomatic, ...choice });
  const automatic = of({});
  assert.ok(automatic.low === -automatic.high && automatic.high > 770 && automatic.high < 790, JSON.stringify(automatic));
  assert.deepEqual(of({ mode: "all" }), { low: -199, high: 800, least: -199, most: 800 });
  const narrow = of({ mode: "percentile", percent: 10 });
  assert.ok(Math.abs(narrow.low + 99) <= 1 && Math.abs(narrow.high - 701) <= 1, JSON.stringify(narrow));
  assert.deepEqual(of({ mode: "typed", low: -5, high: 20 }), { low: -5, high: 20, least: -199, most: 800 });
  const factors = of({ mode: "all", is_log: true });
  assert.ok(factors.low > 0 && factors.high === 800);
  assert.deepEqual([-5, 0, 10, 20].map((v) => u.share_in(v, { low: -5, high: 20 }, false)), [0, 0.5, 0.75, 1]);
  assert.deepEqual([0, 5, 10].map((v) => u.share_in(v, { low: 0, high: 10 }, false)), [0, 0.5, 1]);
  assert.ok(Math.abs(u.share_in(10, { low: 1, high: 100 }, true) - 0.5) < kRounding);
});

test("colors on both sides of 0 grow darker away from it, equally far", () => {
  const lightness = (x) => u.lab_from_linear(u.diverging_color(x))[0];
  for (let i = 0; i < 10; ++i) {
    assert.ok(lightness(0.5 - (i + 1) / 20) < lightness(0.5 - i / 20) && lightness(0.5 + (i + 1) / 20) < lightness(0.5 + i / 20));
  }
  assert.ok(Math.abs(lightness(0) - lightness(1)) < 8);
});

test("numbers are read as people type them", () => {
  assert.deepEqual(["0.5", " 0,5 ", "1e-3", "\u22122", "", "two", "1.2.3"].map(u.parse_number), [0.5, 0.5, 0.001, -2, undefined, undefined, undefined]);
});

test("a pick finds what three.js finds, from either side and through moved objects", () => {
  const { THREE } = u, content = new THREE.Group(), next = random(5);
  for (const x of [-60, 60]) {
    const mesh = new THREE.Mesh(new THREE.TorusKnotGeometry(40, 12, 200, 24), new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }));
    mesh.position.set(x, 5, -x / 3);
    mesh.rotation.set(0.3, x / 100, 0.1);
    mesh.scale.setScalar(x > 0 ? 1.3 : 0.8);
    content.add(mesh);
  }
  content.updateMatrixWorld(true);
  const caster = new THREE.Raycaster();
  let num_hits = 0;
  for (let i = 0; i < 200; ++i) {
    caster.ray.origin.set(220 * (next() - 0.5), 120 * (next() - 0.5), 300);
    caster.ray.direction.set(0.4 * (next() - 0.5), 0.4 * (next() - 0.5), -1).normalize();
    const expected = caster.intersectObject(content, true)[0], found = u.first_hit(caster.ray, content);
    assert.equal(found !== undefined, expected !== undefined);
    if (!found) continue;
    ++num_hits;
    assert.ok(found.point.distanceTo(expected.point) < 1e-3 && found.uv.distanceTo(expected.uv) < 1e-4 && found.object === expected.object);
  }
  assert.ok(num_hits > 50);
});

test("what can be resumed says how far it went and when it was saved, in the time of who reads it", () => {
  const recording = { iterations: 120, events: 7, saved: "2026-11-21T15:04:05Z" };
  const here = new Date(Date.UTC(2026, 10, 21, 15, 4, 5)), two = (n) => String(n).padStart(2, "0");
  const text = u.recording_text(recording, "sv");  // Swedish writes hours and minutes as they are.
  assert.match(text, /^Resume what was painted \(120 iterations, saved .*2026.*\)$/);
  assert.ok(text.includes(`${two(here.getHours())}:${two(here.getMinutes())}`), text);
  assert.match(u.recording_text({ ...recording, iterations: 1 }), /\(1 iteration, /);
  assert.equal(u.recording_text({ ...recording, iterations: 0, saved: "" }), "Resume what was painted (0 iterations)");
  assert.ok(u.is_same_recording(recording, { ...recording }));
  assert.ok(!u.is_same_recording(recording, { ...recording, saved: "2026-11-22T15:04:05Z" }));
  assert.ok(!u.is_same_recording(recording, undefined));
});

test("a brush's way has no gaps but those of the surface", () => {
  const point = (x, y, z) => ({ x, y, z, distanceTo: (o) => Math.hypot(x - o.x, y - o.y, z - o.z) });
  // A plane 1 mm a pixel, with a step of 100 mm down at x = 50 and nothing beyond x = 80.
  const pick = (x, y) => (x > 80 ? undefined : point(x, y, x > 50 ? -100 : 0));
  const spot = (x, y) => ({ x, y, point: pick(x, y) });
  const options = { spacing: 5, mm_per_px: 1, pick };
  const flat = u.way_between(spot(0, 0), spot(40, 30), options);
  assert.deepEqual([flat.at(-1).x, flat.at(-1).y], [40, 30]);
  [spot(0, 0), ...flat].forEach((s, i, all) => assert.ok(i === 0 || s.point.distanceTo(all[i - 1].point) <= 5));
  assert.ok(flat.every((s) => !s.is_jump));
  const over = u.way_between(spot(20, 0), spot(100, 0), options);
  assert.deepEqual(over.filter((s) => s.is_jump).map((s) => s.point.z), [-100], "one edge");
  assert.ok(over.at(-1).x > 76 && over.at(-1).x <= 80, "as far as there is a surface");
  const back = u.way_between(spot(100, 0), spot(60, 0), options);
  assert.ok(back[0].is_jump && back[0].x > 76, "from nowhere onto the surface");
  assert.deepEqual(u.way_between(spot(90, 0), spot(95, 0), options), []);
  const coarse = u.way_between(spot(0, 0), spot(40, 0), { ...options, spacing: 0.1 });
  assert.ok(coarse.every((s) => !s.is_jump), "a brush of less than a pixel is not lifted");
});

test("normals of heights are those of a bowl, whatever the slope of the whole, and unknown places lie flat", () => {
  const [size, texel, bend] = [9, 0.5, 0.3], [sx, sy] = [0.75, -0.4], middle = 4;  // Height: slopes (to the right, and up) and bend (x^2 + y^2) / 2, mm.
  const values = new Float32Array(size * size);
  const place = (i) => [texel * ((i % size) - middle), -texel * (Math.floor(i / size) - middle)];
  for (let i = 0; i < size * size; ++i) {
    const [x, y] = place(i);
    values[i] = 20 + sx * x + sy * y + (bend / 2) * (x * x + y * y);
  }
  const unknown = middle * size + middle;
  values[unknown] = 0;
  const codes = u.normals_of_heights({ width: size, height: size, channels: 1, values }, texel);
  for (let i = 0; i < size * size; ++i) {
    const [column, row] = [i % size, Math.floor(i / size)], [x, y] = place(i);
    const is_inside = column > 0 && row > 0 && column < size - 1 && row < size - 1, is_near = Math.abs(column - middle) + Math.abs(row - middle) === 1;
    if (!is_inside || is_near) continue;  // Differences to one side only: off by half a texel.
    const wanted = i === unknown ? [0, 0, 1] : [-bend * x, -bend * y, 1].map((c) => c / Math.hypot(bend * x, bend * y, 1));
    for (let c = 0; c < 3; ++c) assert.ok(Math.abs(codes[4 * i + c] - 127.5 - 127.5 * wanted[c]) <= 1, `texel ${i}: ${codes.slice(4 * i, 4 * i + 3)}`);  // Codes are whole, heights floats.
  }
  const given = u.codes_of_normals({ width: 2, height: 1, channels: 3, values: new Float32Array([0, 0.6, 0.8, 0, 0, 0]) });
  [127.5, 204, 229.5, 0, 127.5, 127.5, 255, 0].forEach((wanted, i) => assert.ok(Math.abs(given[i] - wanted) <= 0.51, `${given}`));
});

test("a point has one mark in a photograph, inside of it, and undo goes back change by change", () => {
  const photo = { number: 0, name: "a.png", time: "0 s", path: "a.png", width: 20, height: 10 }, other = { ...photo, number: 1, name: "b.png" };
  const marks = new u.Landmarks([{ photo: 0, point: "2", x: 1, y: 2 }, { photo: 0, point: "10", x: 3, y: 4 }]);
  assert.deepEqual(marks.points(), ["2", "10"]);
  assert.equal(marks.new_point(), "1");
  assert.equal(marks.first_missing(0, 1), "2");
  assert.ok(!marks.is_changed && !marks.can_undo);
  marks.begin();
  marks.put(other, "2", 25, -3);
  assert.deepEqual(marks.at(1, "2"), { photo: 1, point: "2", x: 19.5, y: -0.5 });
  assert.equal(marks.first_missing(0, 1), "10");
  marks.begin();
  marks.put(photo, "2", 5.04, 6);
  marks.put(photo, "2", 5.16, 6);
  assert.deepEqual(marks.of_photo(0).find((m) => m.point === "2"), { photo: 0, point: "2", x: 5.2, y: 6 });
  marks.undo();
  assert.equal(marks.at(0, "2").x, 1);
  marks.was_saved();
  assert.ok(!marks.is_changed);
  marks.undo();
  assert.equal(marks.at(1, "2"), undefined);
  assert.ok(marks.is_changed && !marks.can_undo);
});

test("a patch holds the members that differ, and pointers name members with any letters", () => {
  const before = { a: 1, "b/c": { "~d": [1, 2] }, e: 0 }, after = u.copy_of(before);
  u.set_at(after, u.pointer_to("b/c", "~d", 1), 3);
  u.set_at(after, "/f/g", true);
  u.set_at(after, "/a", undefined);
  assert.equal(u.get_at(after, "/b~1c/~0d/1"), 3);
  assert.deepEqual(u.patch_of(before, after), [{ op: "remove", path: "/a" }, { op: "replace", path: "/b~1c", value: { "~d": [1, 3] } }, { op: "add", path: "/f", value: { g: true } }]);
  assert.deepEqual(u.patch_of(before, u.copy_of(before)), []);
});

const kScene = () => ({
  materials: ["water", "rust"], appearance: { rust: { strength: 1 } }, exchange: { rates: { rust: 0.1, water: 0.3 } }, tracing: { wet_material: "water" },
  objects: [{ name: "wall", initial: { rust: "0.5*damp" } }, { name: "sill" }], emitters: [{ name: "rain", carries: { water: 1 } }],
  rules: ["evaporation", { name: "rust", driver: "min(rust, water) * rusty", where: ["wall"], products: { rust: 1 } }],
  events: [{ op: "rate", target: "rust", rate: 0 }, { op: "switch", target: "rain", on: false }, { op: "rule", target: "rust", rate: 1 }], run: { controls: ["hits", "rust.final"] },
});

test("a material's new name goes everywhere that names it, and nowhere else", () => {
  const doc = kScene();
  u.rename(doc, "material", 1, "ochre", "rust");
  assert.deepEqual([doc.materials, doc.appearance, doc.exchange.rates, doc.objects[0].initial], [["water", "ochre"], { ochre: { strength: 1 } }, { ochre: 0.1, water: 0.3 }, { ochre: "0.5*damp" }]);
  assert.deepEqual(doc.rules[1], { name: "rust", driver: "min(ochre, water) * rusty", where: ["wall"], products: { ochre: 1 } });
  assert.deepEqual([doc.events[0].target, doc.events[2].target, doc.run.controls], ["ochre", "rust", ["hits", "ochre.final"]]);
});

test("what is renamed or removed takes its events along", () => {
  const doc = kScene();
  u.rename(doc, "emitter", 0, "storm", "rain");
  u.rename(doc, "object", 0, "house", "wall");
  assert.deepEqual([doc.emitters[0].name, doc.events[1].target, doc.rules[1].where], ["storm", "storm", ["house"]]);
  u.remove(doc, "emitter", 0, "storm");
  u.remove(doc, "rule", 1, "rust");
  assert.deepEqual([doc.emitters, doc.rules, doc.events], [[], ["evaporation"], [{ op: "rate", target: "rust", rate: 0 }]]);
  u.remove(doc, "material", 1, "rust");
  assert.deepEqual([doc.materials, doc.appearance, doc.exchange.rates, doc.run.controls], [["water"], {}, { water: 0.3 }, ["hits"]]);
});

test("copies have names that are free", () => {
  const doc = kScene();
  assert.equal(u.duplicate(doc, "object", 0, ["wall", "sill"]), "wall 2");
  assert.equal(u.duplicate(doc, "object", 1, ["wall", "wall 2", "sill"]), "wall 3");
  assert.deepEqual(doc.objects.map((o) => o.name), ["wall", "wall 2", "wall 3", "sill"]);
  assert.equal(u.duplicate(doc, "material", 1, doc.materials), "rust_2");
  assert.deepEqual([doc.materials, doc.appearance.rust_2], [["water", "rust", "rust_2"], { strength: 1 }]);
});

test("files get names that are files' everywhere, and paths lead from the scene to the mesh", () => {
  assert.equal(u.plain_name("Old wall (north).OBJ"), "Old_wall_north.obj");
  assert.equal(u.plain_name("../../etc/x.stl"), "etc_x.stl");
  assert.equal(u.plain_name("\u00dcrne.ply"), "rne.ply");
  assert.equal(u.plain_name("...glb"), "mesh.glb");
  assert.equal(u.relative_path("a/b/scene.json", "a/c/mesh.obj"), "../c/mesh.obj");
  assert.equal(u.relative_path("scene.json", "mesh.obj"), "mesh.obj");
  assert.equal(u.relative_path("a/scene.json", "a/mesh.obj"), "mesh.obj");
});

test("a mask is painted, filled, and undone to the byte", () => {
  const mask = new u.Mask(200, 150), inside = () => mask.inside.reduce((sum, v) => sum + (v ? 1 : 0), 0);
  mask.begin();
  mask.stroke([20, 30], [150, 100], 12, 0);
  const after = mask.inside.slice();
  for (let y = 0; y < 150; ++y) {
    for (let x = 0; x < 200; ++x) {
      const t = Math.min(1, Math.max(0, ((x - 20) * 130 + (y - 30) * 70) / (130 ** 2 + 70 ** 2))), d = Math.hypot(x - 20 - 130 * t, y - 30 - 70 * t);
      if (Math.abs(d - 12) > kRounding) assert.equal(mask.inside[y * 200 + x], d < 12 ? 0 : 255, `${x}, ${y}`);
    }
  }
  mask.begin();
  mask.fill(Uint8Array.from([1, 0]), 2, 1, 0);  // The left half.
  for (let y = 0; y < 150; ++y) for (let x = 0; x < 200; ++x) assert.equal(mask.inside[y * 200 + x], x < 100 ? 0 : after[y * 200 + x]);
  mask.begin();
  mask.stroke([-50, -50], [300, 300], 400, 255);
  assert.ok(mask.is_everything);
  mask.undo();
  mask.undo();
  assert.deepEqual(mask.inside, after);
  mask.undo();
  assert.equal(inside(), 200 * 150);
  mask.undo();
});

test("a color takes what is like it, connected or everywhere", () => {
  const width = 9, height = 5, data = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < width * height; ++i) data.set(i % width === 4 ? [200, 30, 30, 255] : [90 + (i % 2), 91, 90, 255], 4 * i);  // Gray on both sides of a red line.
  const count = (...given) => u.color_region({ data, width, height }, ...given).reduce((sum, v) => sum + v, 0);
  assert.equal(count(0, 0, 3, true), 4 * height);
  assert.equal(count(0, 0, 3, false), 8 * height);
  assert.equal(count(4, 2, 3, true), height);
  assert.equal(count(0, 0, 100, true), width * height);
});

test("a rectangle has whole pixels inside of the photograph, and a length gives the size of a pixel", () => {
  assert.deepEqual(u.roi_between(3.6, 9.4, -20, -20, 100, 50), [0, 0, 4, 10]);
  assert.deepEqual(u.roi_between(90, 40, 500, 500, 100, 50), [91, 41, 9, 9]);
  assert.equal(u.roi_between(10, 10, 10.4, 30, 100, 50), null);
  assert.deepEqual(u.parse_roi("4, 5  20;10", 100, 50), [4, 5, 20, 10]);
  for (const text of ["4, 5, 97, 10", "4, 5, 20", "4, 5, 0, 10", "-1, 5, 20, 10", "4.5, 5, 20, 10", "a, b, c, d"]) assert.equal(u.parse_roi(text, 100, 50), null, text);
  assert.equal(u.texel_size([{ x: 10, y: 20 }, { x: 13, y: 24 }], 1), 0.2);
  assert.equal(u.texel_size([{ x: 10, y: 20 }, { x: 10, y: 20 }], 1), null);
  for (const mm of [undefined, 0, -1]) assert.equal(u.texel_size([{ x: 10, y: 20 }, { x: 13, y: 24 }], mm), null);
  assert.equal(u.project_text({ roi: [1, 2, 3, 4], texel_size_mm: 0.5, chart: null }, "masks/mask.png"), '"roi": [1, 2, 3, 4],\n"mask": "masks/mask.png",\n"texel_size_mm": 0.5');
});

test("photographs have names of their own in the served folder", () => {
  const names = (...paths) => u.photograph_names(paths.map((path) => ({ file: { name: path.split("/").pop() }, path })));
  assert.deepEqual(names("Urn 2020-05-28 18.20.JPG", "\u00e4.png", "-10min.png"), ["Urn_2020-05-28_18.20.jpg", "photograph.png", "-10min.png"]);
  assert.deepEqual(names("day1/a.jpg", "day2/a.JPG", "b.jpg"), ["day1_a.jpg", "day2_a.jpg", "b.jpg"]);
  assert.deepEqual(names("a b.jpg", "a+b.jpg"), ["a_b.jpg", "a_b_2.jpg"]);
  assert.deepEqual(["a.jpg", "a.CR2", "a.b.mp4", "a.svg", "a.jfif", ".a.jpg", "a.txt", "raw"].map(u.is_photograph), [true, true, true, false, false, false, false, false]);
});

test("a rough mirror loses what theory says, a smooth one nothing", () => {
  const energy = (roughness, cosine) => { const [scale, bias] = u.lobe_energy(roughness, cosine); return scale + bias; };
  const kSamples = 64, kError = 1 / Math.sqrt(kSamples) / 4;  // A quarter of a standard error of random samples: these lie evenly.
  assert.ok(Math.abs(energy(1, 1) - (1 - Math.log(2))) < kError, `${energy(1, 1)}`);
  assert.ok(energy(0.05, 1) > 1 - kError && energy(0.05, 1) <= 1 + kRounding);
});

test("even surroundings light every side alike; what is bright in a picture is a lamp", () => {
  const width = 64, height = 32, rgb = new Float32Array(3 * width * height).fill(1);
  const even = u.surroundings_of_picture({ width, height, rgb });
  assert.equal(even.lamp, undefined);
  const kMean = 0.6, kBand0 = 0.282095, kHarmonics = 1e-5;  // The digits of the constant.
  assert.ok(Math.abs(even.smooth[0][0] * kBand0 - kMean) < kHarmonics * 10, `${even.smooth[0]}`);
  for (const band of even.smooth.slice(1)) for (const c of band) assert.ok(Math.abs(c) < 0.01, `${band}`);
  // A spot in the middle of the right half, 45 degrees up: the middle of the picture is at -z, its right at +x.
  for (const x of [47, 48]) for (const y of [7, 8]) rgb.set([500, 500, 500], 3 * (y * width + x));
  const { lamp } = u.surroundings_of_picture({ width, height, rgb });
  const kPixel_deg = 360 / width;
  assert.ok(Math.abs(lamp.height_deg - 45) < kPixel_deg && Math.abs(lamp.around_deg - 90) < kPixel_deg, JSON.stringify(lamp));
  assert.ok(lamp.half_angle_deg < 2 * kPixel_deg && lamp.is_around);
});

test("both sides of a seam move as one, and thin sheets not at all", () => {
  const box = new u.THREE.BoxGeometry(1, 1, 1);  // Three corners at each of eight places.
  u.add_seams(box);
  const at = (name, i) => { const a = box.getAttribute(name); return Array.from(a.array.slice(a.itemSize * i, a.itemSize * (i + 1))); };
  const seen = new Map();
  for (let i = 0; i < box.getAttribute("position").count; ++i) {
    const key = at("position", i).join(), moves = ["seam_normal", "seam_uv", "seam_uv_more"].map((name) => at(name, i).join()).join(";");
    assert.equal(seen.get(key) ?? moves, moves);
    seen.set(key, moves);
    assert.ok(Math.abs(Math.hypot(...at("seam_normal", i)) - 1) < 1e-6);
  }
  assert.equal(seen.size, 8);
  const sheet = new u.THREE.BufferGeometry();
  sheet.setAttribute("position", new u.THREE.BufferAttribute(new Float32Array(6), 3));
  sheet.setAttribute("normal", new u.THREE.BufferAttribute(new Float32Array([0, 0, 1, 0, 0, -1]), 3));
  sheet.setAttribute("uv", new u.THREE.BufferAttribute(new Float32Array(4), 2));
  u.add_seams(sheet);
  assert.deepEqual([...sheet.getAttribute("seam_normal").array], [0, 0, 0, 0, 0, 0]);
});

test("a large picture of surroundings becomes means of squares", () => {
  const { width, height, rgb } = u.reduced({ width: 2048, height: 2, channels: 4, is_from_top: false, data: Float32Array.from({ length: 2048 * 2 * 4 }, (_, i) => (i % 4 === 0 ? Math.floor(i / 4 / 2048) : 1)) });
  assert.deepEqual([width, height], [1024, 1]);
  assert.deepEqual([...rgb.slice(0, 3)], [0.5, 1, 1]);
});
