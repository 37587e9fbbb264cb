// node look_test.mjs PATINATE: the studio's picture of a running scene against `patinate render` of the same state, with the same camera, light and
// size: mean CIEDE2000 over the object's pixels. Exit code 77: skipped. PATINATE_LOOK_OUT: a folder that gets the pictures.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { copyFile, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { promisify } from "node:util";
import { missing, new_page, open_browser, open_place, patinate, scene_is_ready, serve, until, write_sky } from "./support.mjs";

const program = process.argv[2];
const client = fileURLToPath(new URL("../../tools/studio/client/", import.meta.url));
const why = missing();
if (why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}
const kSide = 320, kRays = 3;  // A pixel is the mean of kRays x kRays, on both sides.
const kCamera = { azimuth: 30, elevation: 12, fov: 28 };
const kMost = 5;  // Mean CIEDE2000: what was asked of the studio. 1 is just noticeable.

const folder = await mkdtemp(join(tmpdir(), "patinate-look-"));
const { build } = createRequire(join(client, "package.json"))("esbuild");
await build({ stdin: { contents: `export * from "./src/color/lab";`, resolveDir: client, loader: "ts" }, bundle: true, format: "esm", platform: "node", outfile: join(folder, "lab.mjs"), logLevel: "warning" });
const { ciede2000, lab_from_linear } = await import(pathToFileURL(join(folder, "lab.mjs")).href);
let server, browser, context, page;

/// Begun in the studio as a person does it, changed, and run.
async function make_scene(name, preset, change) {
  const begun = await fetch(`${server.base}/api/begin?place=urn%2Fmesh.obj`, { method: "POST", headers: { Authorization: `Bearer ${server.token}` }, body: JSON.stringify({ preset, unit: "mm", up: "y", resolution: 512 }) });
  const { place } = await begun.json();
  const scene = JSON.parse((await readFile(join(folder, place), "utf8")).replace(/^\s*\/\/.*$/gm, ""));
  change(scene);
  const file = join(folder, "urn", `${name}.json`);
  await writeFile(file, JSON.stringify(scene));
  await patinate(program, folder, "simulate", `urn/${name}.json`, "-o", name);
}

before(async () => {
  await patinate(program, folder, "synth", "sculpture", "-o", "urn", "--resolution", "40");
  // What it stands on, 1 mm below it.
  await writeFile(join(folder, "urn", "slab.obj"), "v -130 -1.4 -130\nv -130 -1.4 130\nv 130 -1.4 130\nv 130 -1.4 -130\nvt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3 4/4\n");
  server = await serve(program, folder);
  await make_scene("metal", "patina", (scene) => { scene.run.iterations = 150; });
  await make_scene("wet", "rain_and_dirt", (scene) => {
    scene.rules = [];  // Nothing dries.
    scene.objects[0].initial.water = "0.25*damp";
    scene.objects.push({ name: "slab", mesh: "slab.obj", preset: "concrete", initial: { water: "0.2" } });
    scene.run.iterations = 60;
  });
  await make_scene("mossy", "moss", (scene) => {
    scene.objects[0].initial.moss = "1.6*patches";
    scene.run.iterations = 60;
  });
  ({ browser, context } = await open_browser());
  page = await new_page(context);
  page.on("console", (message) => { if (/Shader Error|INVALID_/.test(message.text())) page.problems.push(message.text().slice(0, 500)); });
  await page.goto(server.address);
});

after(async () => {
  await browser?.close();
  await server?.close();
  await rm(folder, { recursive: true, force: true });
});

const linear = (code) => (code <= 0.04045 * 255 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4);

/// In the page: the picture with a camera around the middle of the scene, as rows from the top of linear RGB, and the share of each pixel that the object covers.
async function picture_of_studio(camera) {
  return page.evaluate(async ({ camera, side, rays }) => {
    const { viewer } = window.patinate, radians = (degrees) => (degrees * Math.PI) / 180, { renderer, scene } = viewer;
    const box = viewer.bounds(), target = box.getCenter(viewer.controls.target.clone());
    const distance = 0.8 * box.min.distanceTo(box.max) / 2 / Math.sin(radians(camera.fov) / 2);
    const [a, e] = [radians(camera.azimuth), radians(camera.elevation)];
    const eye = viewer.camera.clone();
    Object.assign(eye, { fov: camera.fov, aspect: 1, near: distance / 100, far: 10 * distance });
    eye.position.set(Math.cos(e) * Math.sin(a), Math.sin(e), Math.cos(e) * Math.cos(a)).multiplyScalar(distance).add(target);
    eye.lookAt(target);
    eye.updateProjectionMatrix();
    const n = side * rays, ratio = renderer.getPixelRatio();
    renderer.setPixelRatio(1);
    renderer.setSize(n, n, false);
    const read = () => {
      renderer.render(scene, eye);
      const gl = renderer.getContext(), bytes = new Uint8Array(4 * n * n);
      gl.readPixels(0, 0, n, n, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      return bytes;
    };
    const seen = read();
    const { background } = scene, others = scene.children.filter((child) => child !== viewer.content && child.visible && !child.isLight);
    scene.background = null;
    for (const child of others) child.visible = false;
    const shown = [];
    viewer.content.traverse((o) => {
      if (!o.isMesh) return;
      shown.push([o, o.material]);
      o.material = new o.material.constructor({ color: 0, emissive: 0xffffff, side: o.material.side });
    });
    renderer.setClearColor(0, 1);
    const mask = read();
    for (const [o, material] of shown) o.material = material;
    scene.background = background;
    for (const child of others) child.visible = true;
    renderer.setPixelRatio(ratio);
    viewer.on_resize?.();
    const codes = new Array(3 * side * side).fill(0), cover = new Array(side * side).fill(0);
    const to_linear = (code) => (code <= 10.31475 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4);
    for (let y = 0; y < n; ++y) {
      for (let x = 0; x < n; ++x) {
        const at = Math.floor((n - 1 - y) / rays) * side + Math.floor(x / rays), from = 4 * (y * n + x);
        for (let c = 0; c < 3; ++c) codes[3 * at + c] += to_linear(seen[from + c]) / rays / rays;
        cover[at] += (mask[from] > 127 ? 1 : 0) / rays / rays;
      }
    }
    return { rgb: codes, cover, target: target.toArray(), distance };
  }, { camera, side: kSide, rays: kRays });
}

/// Codes of a PNG as rows from the top of linear RGB. Not in the studio's page, whose policy would not let it.
async function read_png(bytes) {
  const { codes, width, height } = await other_page().then((p) => p.evaluate(async (source) => {
    const image = new Image();
    image.src = source;
    await image.decode();
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    return { codes: [...context.getImageData(0, 0, image.width, image.height).data].filter((_, i) => i % 4 !== 3), width: image.width, height: image.height };
  }, `data:image/png;base64,${bytes.toString("base64")}`));
  return { rgb: codes.map(linear), width, height };
}

async function picture_of_render(name, { target, distance }, camera, ...more) {
  await patinate(program, folder, "render", name, "-o", `${name}.png`, "--force", "--width", kSide, "--height", kSide, "--samples", kRays * kRays, "--num-times", "1",
    "--azimuth", camera.azimuth, "--elevation", camera.elevation, "--fov", camera.fov, "--target", target.join(","), "--distance", distance, ...more);
  return (await read_png(await readFile(join(folder, `${name}.png`)))).rgb;
}
let blank;
async function other_page() {
  return blank ??= await context.newPage();
}

/// Writes rows of linear RGB as a picture, for who looks at what the numbers are about.
async function keep(name, rgb) {
  const out = process.env.PATINATE_LOOK_OUT;
  if (!out) return;
  const code = (v) => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * Math.min(1, v) ** (1 / 2.4) - 0.055);
  const url = await (await other_page()).evaluate(({ codes, side }) => {
    const canvas = Object.assign(document.createElement("canvas"), { width: side, height: side }), drawing = canvas.getContext("2d");
    const data = drawing.createImageData(side, side);
    for (let i = 0; i < side * side; ++i) data.data.set([codes[3 * i], codes[3 * i + 1], codes[3 * i + 2], 255], 4 * i);
    drawing.putImageData(data, 0, 0);
    return canvas.toDataURL("image/png");
  }, { codes: rgb.map((v) => Math.round(code(v))), side: kSide });
  await writeFile(join(out, `${name}_studio.png`), Buffer.from(url.split(",")[1], "base64"));
}

/// Over the pixels that the object covers wholly: mean CIEDE2000, and by how much the mean lightness is off.
function difference(ours, theirs, cover) {
  let sum = 0, lighter = 0, count = 0;
  for (let i = 0; i < cover.length; ++i) {
    if (cover[i] < 0.999) continue;
    const [a, b] = [ours, theirs].map((rgb) => lab_from_linear([rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]]));
    sum += ciede2000(a, b);
    lighter += a[0] - b[0];
    count += 1;
  }
  return { mean: sum / count, lighter: lighter / count, count };
}

async function compare(name, light, ...more) {
  const seen = await picture_of_studio(kCamera), rendered = await picture_of_render(name, seen, kCamera, ...more);
  const { mean, lighter, count } = difference(seen.rgb, rendered, seen.cover);
  console.log(`${name}, ${light}: mean CIEDE2000 ${mean.toFixed(2)} over ${count} pixels; L* ${lighter.toFixed(2)} off in the mean`);
  await keep(`${name}_${light}`, seen.rgb);
  if (process.env.PATINATE_LOOK_OUT) await copyFile(join(folder, `${name}.png`), join(process.env.PATINATE_LOOK_OUT, `${name}_${light}_render.png`));
  return mean;
}

async function open_at_rest(name) {
  await open_place(page, server, name, "live");
  await scene_is_ready(page);
  await until(page, () => window.patinate.viewer.is_at_rest);
}

for (const name of ["metal", "wet", "mossy"]) {
  test(`the ${name} scene looks as render draws it`, async () => {
    await open_at_rest(name);
    assert.ok(await compare(name, "studio") < kMost);
    assert.deepEqual(page.problems, []);
  });
}

for (const name of ["metal", "wet"]) {
  test(`the ${name} scene looks as render draws it under a sky from a file`, async () => {
    await write_sky(join(folder, "sky.hdr"));
    await open_at_rest(name);
    await page.locator("summary", { hasText: /^Light$/ }).click();
    await page.getByLabel("A picture of surroundings").setInputFiles(join(folder, "sky.hdr"));
    await until(page, () => [...document.querySelectorAll("select")].some((s) => s.value === "sky.hdr"));
    const options = await page.evaluate((azimuth) => window.patinate.viewer.light_options(azimuth), kCamera.azimuth);
    assert.equal(options.backdrop, "environment");
    assert.ok(await compare(name, "sky", "--environment", "sky.hdr", `--environment-azimuth=${options.environment_azimuth}`, "--backdrop", "environment") < kMost);
    assert.deepEqual(page.problems, []);
  });
}

test("a picture is saved in its size, and the command beside it draws the same", async () => {
  const kWidth = 320, kHeight = 200;
  await open_at_rest("metal");
  await page.locator("summary", { hasText: /^Picture$/ }).click();
  const panel = page.locator("details", { has: page.locator("summary", { hasText: /^Picture$/ }) });
  for (const [label, value] of [["Width", kWidth], ["Height", kHeight]]) {
    await panel.getByLabel(label, { exact: true }).fill(String(value));
    await page.keyboard.press("Tab");
  }
  const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save the picture" }).click()]);
  assert.equal(file.suggestedFilename(), "metal.png");
  const ours = await read_png(await readFile(await file.path()));
  assert.deepEqual([ours.width, ours.height], [kWidth, kHeight]);
  const words = (await page.locator("dialog .command").last().textContent()).split(" ");
  assert.deepEqual(words.slice(0, 5), ["patinate", "render", "metal", "-o", "metal.png"]);
  await promisify(execFile)(program, [...words.slice(1), "--force", "--quiet", "--num-times", "1"], { cwd: folder });
  const theirs = await read_png(await readFile(join(folder, "metal.png")));
  // The middle of the picture is the middle of the urn.
  const middle = Array.from({ length: kWidth * kHeight }, (_, i) => (Math.abs((i % kWidth) - kWidth / 2) < 15 && Math.abs(Math.floor(i / kWidth) - kHeight / 2) < 15 ? 1 : 0));
  const { mean } = difference(ours.rgb, theirs.rgb, middle);
  assert.ok(mean < kMost, `${mean}`);
  await page.keyboard.press("Escape");
  await page.getByRole("button", { name: "Turntable" }).click();
  await until(page, () => /^patinate render metal .*--turntable 72/.test(document.querySelector("dialog .command")?.textContent ?? ""));
  await page.keyboard.press("Escape");
});

test("heights move the mesh that is cut to texels, and nothing opens along seams", async () => {
  await open_at_rest("wet");
  const vertices = () => page.evaluate(() => { let sum = 0; window.patinate.viewer.content.traverse((o) => { if (o.isMesh && !o.isInstancedMesh) sum += o.geometry.getAttribute("position").count; }); return sum; });
  const before = await vertices();
  await page.locator("summary", { hasText: "What is shown" }).scrollIntoViewIfNeeded();
  await page.getByRole("textbox", { name: "Displacement" }).fill("5");
  await page.keyboard.press("Enter");
  await until(page, (n) => { let sum = 0; window.patinate.viewer.content.traverse((o) => { if (o.isMesh && !o.isInstancedMesh) sum += o.geometry.getAttribute("position").count; }); return sum > 2 * n; }, before);
  // All vertices of a place move in the same way.
  const [num_shared, num_apart] = await page.evaluate(() => {
    let shared = 0, apart = 0;
    window.patinate.viewer.content.traverse((o) => {
      if (!o.isMesh || o.isInstancedMesh) return;
      const { position, seam_normal, seam_uv, seam_uv_more } = o.geometry.attributes, seen = new Map();
      for (let i = 0; i < position.count; ++i) {
        const at = (attribute) => Array.from(attribute.array.slice(attribute.itemSize * i, attribute.itemSize * (i + 1))).join(" ");
        const key = at(position), moves = [seam_normal, seam_uv, seam_uv_more].map(at).join(" ");
        if (!seen.has(key)) seen.set(key, moves);
        else if (seen.get(key) === moves) ++shared;
        else ++apart;
      }
    });
    return [shared, apart];
  });
  assert.ok(num_shared > 0);
  assert.equal(num_apart, 0);
  await until(page, () => window.patinate.viewer.is_at_rest);
  assert.deepEqual(page.problems, []);
});
