// node browser_test.mjs PATINATE: the studio in a real browser, on data made by `synth` and a real simulation. Exit code 77: skipped.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { request } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { history_is_ready, make_wall, missing, new_page, open_browser, open_place, patinate, scene_is_ready, serve, until } from "./support.mjs";

const program = process.argv[2];
const why = missing();
if (why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const nightly = process.env.PATINATE_NIGHTLY ? test : (name) => test(name, { skip: "runs nightly" }, () => {});
const folder = await mkdtemp(join(tmpdir(), "patinate-studio-"));
let server, browser, context, page;

before(async () => {
  const make = (...parameters) => patinate(program, folder, ...parameters);
  await Promise.all([
    (async () => {
      await make("synth", "crackle", "-o", "crackle", "--width", "160", "--height", "160", "--num-frames", "6");
      await make("ingest", "crackle/capture.json", "-o", "history");
      await make("synth", "sculpture", "-o", "urn", "--resolution", "30");
      await make("transfer", "history", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "256", "-o", "aged");
      await writeFile(join(folder, "black.json"), JSON.stringify({ format: "patinate.appearance", version: 1, metalness: 1, roughness: 1, tint: "#010101" }));  // Black is: nobody knows.
      await make("history", "material", "history", "black.json", "-o", "black");
      await make("transfer", "black", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "256", "-o", "black_urn");
    })(),
    (async () => {
      await make_wall(program, folder);
      await make("simulate", "wall/scene.json", "-o", "wet");
      await make("synth", "mold", "-o", "mold", "--width", "100", "--height", "75");
      await make("register", "mold/step00/scan.ply", "mold/step01/scan.ply", "--unit", "mm", "-o", "registered");
      await make("register", "mold/step00/scan.ply", "mold/step01/scan.ply", "mold/step02/scan.ply", "--unit", "mm", "-o", "moved");
      await make("height-change", "moved", "-o", "receding");
      await make("ingest", "mold/capture.json", "-o", "copper");
      const capture = JSON.parse(await readFile(join(folder, "mold/capture.json"), "utf8"));
      const { photos, ambient, scan } = capture.steps[0];
      const { unit, response, camera, lights } = capture;
      await writeFile(join(folder, "mold/step.json"), JSON.stringify({ format: "patinate.unlight", version: 1, unit, response, camera, lights, photos, ambient, scan }));
      await make("unlight", "mold/step.json", "-o", "unlit");
    })(),
  ]);
  server = await serve(program, folder);
  ({ browser, context } = await open_browser());
  page = await new_page(context);
  await page.goto(server.address);
});

after(async () => {
  await browser?.close();
  await server?.close();
  await rm(folder, { recursive: true, force: true });
});

const in_page = (f, argument) => page.evaluate(f, argument);
const iteration = () => in_page(() => window.patinate.status()?.iteration ?? 0);
const overlay_at = (uv) => in_page(({ x, y }) => {
  const plane = window.patinate.planes().overlay;
  return plane.data[Math.floor(y * plane.height) * plane.width + Math.floor(x * plane.width)];
}, uv);
/// What the browser holds equals what the server has; @returns the hash of both.
async function same_planes(p = page) {
  const { server: there, here } = await p.evaluate(() => window.patinate.check_hash());
  assert.equal(here.surface, there.surface);
  assert.equal(here.relief, there.relief);
  assert.equal(here.material, there.material);  // Water is there: it is a film.
  return here.surface + here.relief + here.material;
}
async function run_for(iterations) {
  const from = await iteration();
  await in_page(() => window.patinate.send("run"));
  await until(page, (end) => window.patinate.status().iteration >= end, from + iterations);
  await in_page(() => window.patinate.send("pause"));
  await until(page, () => window.patinate.status().running === false);
}

test("wrong tokens, foreign hosts and origins, and ways out of the folder are refused", async () => {
  const ask = (path, headers) => new Promise((resolve, reject) => {
    request({ host: "127.0.0.1", port: server.port, path, headers }, (answer) => { answer.resume(); resolve(answer.statusCode); }).on("error", reject).end();
  });
  const token = { Authorization: `Bearer ${server.token}` };
  assert.equal(await ask("/api/places", token), 200);
  assert.equal(await ask("/api/places", {}), 403);
  assert.equal(await ask("/api/places", { Authorization: "Bearer 00" }), 403);
  assert.equal(await ask("/api/places", { ...token, Host: "elsewhere.example" }), 403);
  assert.equal(await ask("/api/places", { ...token, Origin: "http://elsewhere.example" }), 403);
  assert.equal(await ask("/api/file?place=..%2F..%2Fetc&path=passwd", token), 404);
  const stranger = await browser.newContext();
  const other = await stranger.newPage();
  assert.equal((await other.goto(`${server.base}/?token=00`)).status(), 403);
  await stranger.close();
});

test("the start page has a card for every place, with pictures where there are some", async () => {
  await page.waitForSelector(".card");
  const kinds = await in_page(() => [...document.querySelectorAll(".card .kind")].map((e) => e.textContent));
  for (const kind of ["scene", "transfer", "simulation", "history", "capture", "mesh"]) assert.ok(kinds.includes(kind), kind);
  for (const kind of ["scene", "transfer", "simulation", "mesh"]) {
    await page.locator(`.card.${kind}`).first().scrollIntoViewIfNeeded();
    await until(page, (k) => document.querySelector(`.card.${k} img.object`)?.naturalWidth > 0, kind);
  }
});

test("the time slider shows the texture whose hash the server gives", async () => {
  for (const place of ["history", "aged", "wet"]) {
    await open_place(page, server, place);
    await history_is_ready(page);
    const { times } = await (await server.get(`/api/place?place=${place}`)).json();
    for (const share of [0.37, 1]) {
      await page.locator(".time input").first().evaluate((input, s) => {
        input.value = String(Number(input.min) + s * (Number(input.max) - Number(input.min)));
        input.dispatchEvent(new Event("input", { bubbles: true }));
      }, share);
      const time = await page.locator(".time input").first().inputValue();
      assert.ok(Number(time) <= times.at(-1));
      await in_page(() => window.patinate.settled());
      const answer = await server.get(`/api/texture?place=${place}&time=${time}&format=raw`);
      await answer.arrayBuffer();
      assert.equal(await in_page(() => window.patinate.texture_hash()), answer.headers.get("X-Hash"), `${place} at ${time}`);
    }
  }
});

test("a click on a transfer shows its curve and the photograph it comes from; keys compare two times", async () => {
  await open_place(page, server, "aged");
  await history_is_ready(page);
  await page.mouse.click(470, 330);
  await page.waitForSelector(".curve-panel .chart");
  await until(page, () => document.querySelector(".source img")?.naturalWidth > 0);
  assert.match(await page.locator(".texel").textContent(), /comes from pixel/);
  await page.keyboard.press("2");
  assert.ok(await page.locator(".wipe").isVisible());
  await page.keyboard.press("3");
  await page.waitForSelector(".legend");
  assert.ok(!(await page.locator(".wipe").isVisible()));
  await page.locator("select", { hasText: "nothing" }).selectOption({ label: "where it comes from" });
  await until(page, () => document.querySelectorAll(".legend").length === 2);
});

test("the cursor shows a map's value and the color; all numbers of a place are saved as a table", async () => {
  await open_place(page, server, "wet");
  await history_is_ready(page);
  await page.locator("select", { hasText: "nothing" }).selectOption("amount:water");
  await page.keyboard.press("ArrowRight");
  await page.waitForSelector(".legend");
  await in_page(() => window.patinate.settled());
  const at = await in_page(() => { const { viewer } = window.patinate, { x, y } = viewer.project(viewer.bounds().getCenter(viewer.controls.target.clone()).setX(-180).setY(250).setZ(8)); return { x, y }; });
  await page.mouse.move(at.x + 3, at.y);
  await page.mouse.move(at.x, at.y);
  await until(page, () => /^amount of water: [\d.]+L\* \d/.test(document.querySelector(".hover-tag")?.textContent ?? ""));
  await page.mouse.click(at.x, at.y);
  await page.locator(".curve-panel .chart").nth(1).waitFor();  // Color, and amounts.
  const texel = /Texel (\d+), (\d+)/.exec(await page.locator(".texel").textContent());
  const curve = await (await server.get(`/api/curve?place=wet&x=${texel[1]}&y=${texel[2]}`)).json();
  const [file] = await Promise.all([page.waitForEvent("download"), page.locator(".curve-panel").getByRole("button", { name: "Save as CSV" }).click()]);
  const rows = (await readFile(await file.path(), "utf8")).trim().split("\n").map((line) => line.split(","));
  assert.equal(rows.length, 1 + curve.times.length);
  const water = rows[0].indexOf("water (amount)");
  assert.deepEqual(rows.slice(1).map((row) => Number(row[water])), curve.values.find((v) => v.name === "water").values);
  assert.ok(curve.values[0].values.length === curve.times.length && rows[0].includes("hits (1/mm2)"), rows[0].join());
});

test("regions that are drawn have their means, over time and in a table", async () => {
  await open_place(page, server, "history");
  await history_is_ready(page);
  await page.locator("summary", { hasText: "Regions" }).click();
  await page.getByRole("button", { name: "Draw a region" }).click();
  await page.mouse.move(400, 250);
  await page.mouse.down();
  for (const [x, y] of [[520, 250], [520, 370], [400, 370], [400, 252]]) await page.mouse.move(x, y, { steps: 4 });
  await page.mouse.up();
  await page.locator(".regions tbody tr").waitFor();
  assert.match(await page.locator(".name-tag").textContent(), /^A$/);
  const said = (await page.locator(".regions tbody td").allTextContents()).slice(0, 3).map(Number);
  // The same texels of the server's texture, averaged here.
  const [low, high] = await in_page(() => [[400, 250], [520, 370]].map(([x, y]) => { const { uv } = window.patinate.viewer.pick(x, y); return { x: uv.x, y: uv.y }; }));
  const answer = await server.get("/api/texture?place=history&time=0&format=raw"), bytes = new Uint8Array(await answer.arrayBuffer()), width = Number(answer.headers.get("X-Width")), height = Number(answer.headers.get("X-Height"));
  let sum = 0, count = 0;
  for (let y = Math.ceil(low.y * height); y < high.y * height; ++y) for (let x = Math.ceil(low.x * width); x < high.x * width; ++x, ++count) sum += [0.2126729, 0.7151522, 0.072175].reduce((all, weight, c) => { const v = bytes[4 * (y * width + x) + c] / 255; return all + weight * (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); }, 0);
  const L = 116 * Math.cbrt(sum / count) - 16;
  assert.ok(Math.abs(said[0] - L) < 1, `${said} and ${L}`);  // Texels on the line count or not.
  await page.getByRole("button", { name: "Curves over time" }).click();
  await page.locator("details", { has: page.locator("summary", { hasText: "Regions" }) }).locator(".chart").waitFor();
});

test("two results have one camera and one time, and a difference where they lie on one texture", async () => {
  await page.goto(`${server.base}/#/aged?${encodeURIComponent("with:black_urn")}`);
  await page.reload();
  const is_ready = () => until(page, () => window.patinate?.view === "compare" && window.patinate.is_ready());
  await is_ready();
  const eyes = () => in_page(() => window.patinate.sides.map(({ viewer }) => viewer.camera.position.toArray()));
  const before = await eyes();
  await page.mouse.move(250, 400);
  await page.mouse.down();
  await page.mouse.move(340, 420, { steps: 4 });
  await page.mouse.up();
  const [left, right] = await eyes();
  assert.ok(Math.hypot(...left.map((c, i) => c - before[0][i])) > 1 && Math.hypot(...left.map((c, i) => c - right[i])) < 1e-6, JSON.stringify({ left, right }));
  await page.getByRole("radio", { name: "Difference" }).click();
  await page.waitForSelector(".legend");
  assert.match(await page.locator(".facts", { hasText: "Mean difference" }).textContent(), /Mean difference[\d.]+ ΔE/);
  await page.goto(`${server.base}/#/aged?${encodeURIComponent("with:wet")}`);
  await page.reload();
  await is_ready();
  assert.equal(await page.getByRole("radio", { name: "Difference" }).isEnabled(), false);
  await open_place(page, server, "aged");
  await history_is_ready(page);
});

test("a map with numbers on both sides of 0 has a color for each, and stripes where nothing is known", async () => {
  await open_place(page, server, "receding");
  await history_is_ready(page);
  await page.waitForSelector(".legend");  // It opens as what it is about.
  assert.match(await page.locator(".legend").textContent(), /^height \(mm\)-0\.\d+ and less00\.\d+ and more.*not known$/);
  const color_at = (value) => in_page(async (is_negative) => {
    const { viewer } = window.patinate;
    const { data } = window.patinate.overlay();
    // The least, the largest, or one in the middle of what is not known.
    const { width, values } = data;
    let i = 0;
    if (is_negative === null) i = values.findIndex((v, k) => k > 2 * width && [-1, 0, 1].every((dy) => [-1, 0, 1].every((dx) => Number.isNaN(values[k + dy * width + dx]))));
    else values.forEach((v, k) => { if (!Number.isNaN(v) && (Number.isNaN(values[i]) || (is_negative ? v < values[i] : v > values[i]))) i = k; });
    const uv = { x: ((i % width) + 0.5) / width, y: (Math.floor(i / width) + 0.5) / data.height };
    const box = viewer.bounds(), point = box.min.clone();
    point.set(box.min.x + uv.x * (box.max.x - box.min.x), box.max.y - uv.y * (box.max.y - box.min.y), 0);
    viewer.renderer.render(viewer.scene, viewer.camera);
    const gl = viewer.renderer.getContext(), pixel = new Uint8Array(4), p = point.project(viewer.camera);
    gl.readPixels(((p.x + 1) / 2) * gl.drawingBufferWidth, ((p.y + 1) / 2) * gl.drawingBufferHeight, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return [...pixel];
  }, value);
  await page.locator("summary", { hasText: /^Light$/ }).click();
  await page.getByText("Light its relief").click();
  const below = await color_at(true), above = await color_at(false), unknown = await color_at(null);
  assert.ok(below[2] > below[0] + 20, `below 0: ${below}`);
  assert.ok(above[0] > above[2] + 20, `above 0: ${above}`);
  assert.ok(Math.abs(unknown[0] - unknown[2]) < 8, `not known: ${unknown}`);
  await page.locator("select", { hasText: "automatic" }).selectOption("typed");
  await page.getByRole("textbox", { name: "From", exact: true }).fill("-0.5");
  await page.keyboard.press("Enter");
  await page.getByRole("textbox", { name: "To", exact: true }).fill("0,25");
  await page.keyboard.press("Tab");
  await until(page, () => /-0\.500\.25/.test(document.querySelector(".legend").textContent));
  await page.locator("select", { hasText: "nothing" }).selectOption("map:normal");
  await until(page, () => document.querySelector(".legend.vector"));
  await page.locator("select", { hasText: "as a color" }).selectOption("z");
  await until(page, () => /normal, z/.test(document.querySelector(".legend").textContent));
  await open_place(page, server, "aged");
  await history_is_ready(page);
});

nightly("a metal that mirrors nothing is black in any light, and has its colors without light", async () => {
  const code_in_the_middle = async () => {
    await until(page, () => window.patinate.viewer.is_at_rest);
    return in_page(() => {
      const { viewer } = window.patinate;
      viewer.renderer.render(viewer.scene, viewer.camera);
      const gl = viewer.renderer.getContext(), pixel = new Uint8Array(4);
      gl.readPixels(gl.drawingBufferWidth / 2, gl.drawingBufferHeight / 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      return Math.max(pixel[0], pixel[1], pixel[2]);
    });
  };
  await open_place(page, server, "black_urn");
  await history_is_ready(page);
  await page.evaluate(() => window.patinate.settled());
  const lit = await code_in_the_middle();
  assert.ok(lit < 16, `lit: ${lit}`);  // Fresnel's white at grazing angles is not in the middle.
  await page.locator("summary", { hasText: /^Light$/ }).click();
  await page.getByText("Exact colors, without light").click();
  assert.ok(await code_in_the_middle() > 64, "exact colors");
  await open_place(page, server, "aged");
  await history_is_ready(page);
});

test("a saved session opens without a server, at the time it was saved", async () => {
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save as one HTML file" }).click()]);
  const file = join(folder, "session.html");
  await download.saveAs(file);
  const alone = await new_page(await browser.newContext());
  await alone.goto(pathToFileURL(file).href);
  await history_is_ready(alone);
  assert.equal(await alone.locator(".time input").count(), 2);
  const first = await alone.evaluate(() => window.patinate.texture_hash());
  await alone.keyboard.press("ArrowRight");
  await alone.evaluate(() => window.patinate.settled());
  assert.notEqual(await alone.evaluate(() => window.patinate.texture_hash()), first);
  assert.deepEqual(alone.problems, []);
  await alone.context().close();
});

test("a lamp shows the relief of a flat history, from where it is put", async () => {
  await open_place(page, server, "copper");
  await history_is_ready(page);
  const look = async () => {
    await until(page, () => window.patinate.viewer.is_at_rest);
    return (await page.locator(".stage canvas").first().screenshot()).toString("base64");
  };
  const flat = await look();
  await in_page(() => window.patinate.light_relief(true));
  const from_left = await look();
  assert.notEqual(from_left, flat);
  await page.locator("summary", { hasText: /^Light$/ }).click();
  await slide("Lamp from", -45);
  assert.notEqual(await look(), from_left);
  await in_page(() => window.patinate.light_relief(false));
  assert.equal(await look(), flat);
});

test("a capture shows its photographs", async () => {
  await open_place(page, server, "crackle");
  await until(page, () => document.querySelector(".pictures img")?.naturalWidth > 0);
  await page.locator(".pictures button").first().click();
  await until(page, () => document.querySelector(".light-box img")?.naturalWidth > 0);
  await page.keyboard.press("Escape");
});

nightly("registered scans lie in one frame, each in its color, and can be hidden", async () => {
  await open_place(page, server, "registered");
  await until(page, () => Object.keys(window.patinate?.scans?.() ?? {}).length === 2);
  assert.match(await page.locator(".scan-list label").nth(2).textContent(), /step01\/scan\.ply.*RMS 0\.\d+ mm, overlap \d+/);
  const size = await in_page(() => { const box = window.patinate.viewer.bounds(); return box.max.x - box.min.x; });
  assert.ok(size > 50 && size < 300, `${size} mm wide`);
  await page.locator("input[data-scan='step01/scan.ply']").uncheck();
  assert.deepEqual(await in_page(() => window.patinate.scans()), { "step00/scan.ply": true, "step01/scan.ply": false });
  await until(page, () => document.querySelector(".pictures img")?.naturalWidth > 0);
});

test("an unlit step shows its maps and what became of its photographs", async () => {
  await open_place(page, server, "unlit");
  await until(page, () => [...document.querySelectorAll(".pictures img")].filter((image) => image.naturalWidth > 0).length >= 5);
  assert.match(await page.locator("figcaption").last().textContent(), /light 5: residual .* %, predicted from the others .* % off/);
});

nightly("fingers turn, pinch, slide and paint", async () => {
  const touching = await browser.newContext({ viewport: { width: 640, height: 860 }, hasTouch: true });
  const tablet = await new_page(touching);
  await tablet.goto(server.address);
  const client = await touching.newCDPSession(tablet);
  const touch = (type, ...points) => client.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  /// Fingers go from their first points to their last ones.
  const drag = async (...fingers) => {
    const kSteps = 6;
    await touch("touchStart", ...fingers.map(([from]) => from));
    for (let i = 1; i <= kSteps; ++i) await touch("touchMove", ...fingers.map(([from, to]) => from.map((c, k) => c + ((to[k] - c) * i) / kSteps)));
    await touch("touchEnd");
  };
  const eye = () => tablet.evaluate(() => { const { camera, controls } = window.patinate.viewer; return { at: camera.position.clone().sub(controls.target).normalize().toArray(), far: camera.position.distanceTo(controls.target) }; });
  await open_place(tablet, server, "aged");
  await history_is_ready(tablet);
  const start = await eye();
  await drag([[400, 300], [550, 300]]);
  const turned = await eye();
  assert.ok(Math.hypot(...turned.at.map((c, i) => c - start.at[i])) > 0.2, "one finger turns");
  assert.ok(Math.abs(turned.far / start.far - 1) < 1e-6);
  await drag([[380, 300], [250, 300]], [[440, 300], [570, 300]]);
  assert.ok((await eye()).far < 0.7 * turned.far, "two fingers come closer");
  const track = await tablet.locator(".time input").first().boundingBox();
  const y = track.y + track.height / 2, before = await tablet.evaluate(() => window.patinate.texture_hash());
  await drag([[track.x + 9, y], [track.x + 0.8 * track.width, y]]);
  await tablet.evaluate(() => window.patinate.settled());
  assert.ok(Number(await tablet.locator(".time input").first().inputValue()) > 1, "the slider follows");
  assert.notEqual(await tablet.evaluate(() => window.patinate.texture_hash()), before);
  await open_place(tablet, server, "wall/scene.json");
  await scene_is_ready(tablet);
  const clean = await same_planes(tablet);
  await tablet.getByRole("button", { name: "Paint" }).tap();
  await tablet.locator("select", { hasText: "spout" }).selectOption("brush");
  const stage = await tablet.locator(".stage").boundingBox();
  const middle = [stage.x + stage.width / 2, stage.y + stage.height / 2];
  await drag([middle, [middle[0] + 60, middle[1]]]);
  await until(tablet, () => window.patinate.status().can_undo && !window.patinate.status().painting);
  assert.notEqual(await same_planes(tablet), clean);
  const painting = await eye();
  await drag([[middle[0] - 40, middle[1]], [middle[0] - 120, middle[1]]], [[middle[0] + 40, middle[1]], [middle[0] + 120, middle[1]]]);
  assert.ok((await eye()).far < 0.9 * painting.far, "two fingers still move the camera");
  await tablet.evaluate(() => window.patinate.send("undo"));
  assert.equal(await same_planes(tablet), clean);
  await until(tablet, () => window.patinate.status().can_undo === false);
  assert.deepEqual(tablet.problems, []);
  await touching.close();
});

test("a running scene arrives to the bit", async () => {
  await open_place(page, server, "wall/scene.json");
  await scene_is_ready(page);
  const start = await same_planes();
  await run_for(10);
  assert.notEqual(await same_planes(), start);
});

test("a dragged emitter wets other texels", async () => {
  await page.locator("select", { hasText: "nothing" }).selectOption("water");
  await page.locator(".thing button", { hasText: "spout" }).click();
  // Where the spout will be after the drag, on the wall.
  const ways = await in_page(() => {
    const { viewer, handles } = window.patinate;
    const spout = handles.shapes.get("spout").position;
    const at = viewer.project(spout), right = viewer.project(spout.clone().setX(spout.x + 10));
    const mm_px = Math.hypot(right.x - at.x, right.y - at.y) / 10;
    const way = { x: (right.x - at.x) / 10 / mm_px, y: (right.y - at.y) / 10 / mm_px };
    const foot = viewer.project(spout.clone().set(spout.x + 300, spout.y, 5));
    const hit = viewer.pick(foot.x, foot.y);
    return { at, way, mm_px, uv: { x: hit.uv.x, y: hit.uv.y } };
  });
  const { at, way, mm_px, uv } = ways;
  await page.waitForTimeout(300);
  await until(page, () => window.patinate.viewer.is_at_rest);  // The handles are where they are drawn.
  assert.equal(await overlay_at(uv), 0);
  const kGrip_px = 45;
  await page.mouse.move(at.x + kGrip_px * way.x, at.y + kGrip_px * way.y);
  await page.mouse.down();
  const far = kGrip_px + 300 * mm_px;
  await page.mouse.move(at.x + (far / 2) * way.x, at.y + (far / 2) * way.y, { steps: 3 });
  await page.mouse.move(at.x + far * way.x, at.y + far * way.y, { steps: 3 });
  await page.mouse.up();
  await until(page, () => Math.abs(window.patinate.scene().emitters.find((e) => e.name === "spout").position[0] - 100) < 40);
  await run_for(20);
  await same_planes();
  assert.ok((await overlay_at(uv)) > 0, "the wall under the new place is wet");
  await page.keyboard.press("Escape");
});

test("a stroke of the brush has no gaps and takes no time; undo and redo", async () => {
  const start = await same_planes();
  const from = await iteration();
  await in_page(() => window.patinate.send("run"));  // The weather stands still while one paints.
  await page.keyboard.press("p");
  await page.locator("select", { hasText: "spout" }).selectOption("brush");
  // From left to right in one leap, as a browser tells that has no time: nothing lies between but the surface.
  const [left, right] = [{ x: 420, y: 500 }, { x: 640, y: 510 }];
  const uvs = await in_page(([a, b]) => Array.from({ length: 23 }, (_, i) => {
    const { uv } = window.patinate.viewer.pick(a.x + (i / 22) * (b.x - a.x), a.y + (i / 22) * (b.y - a.y));
    return { x: uv.x, y: uv.y };
  }), [left, right]);
  await page.mouse.move(left.x, left.y);
  await page.mouse.down();
  await until(page, () => window.patinate.status().painting);
  const at = await iteration();
  await page.mouse.move(right.x, right.y);
  await page.waitForTimeout(500);
  assert.equal(await page.locator(".run-bar .state").textContent(), "painting");
  assert.equal(await iteration(), at, "time stands still");
  // Before the brush is lifted: once time continues, at hundreds of iterations a second, the water dries and runs away. Gammatons fall at random in a brush
  // 17 texels wide, so one texel may stay dry by chance; half of those within a sixth of its width cannot, but in a gap of the way all of them are dry.
  const least_wet = () => in_page((places) => {
    const { width, height, data } = window.patinate.planes().overlay, kRadius_px = 3;
    return Math.min(...places.map(({ x, y }) => {
      let wet = 0, all = 0;
      for (let dy = -kRadius_px; dy <= kRadius_px; ++dy) {
        for (let dx = -kRadius_px; dx <= kRadius_px; ++dx) {
          if (dx * dx + dy * dy > kRadius_px ** 2) continue;
          ++all;
          if (data[(Math.floor(y * height) + dy) * width + Math.floor(x * width) + dx] > 0) ++wet;
        }
      }
      return wet / all;
    }));
  }, uvs);
  let share = 0;  // The colors come with a picture of their own.
  for (const end = Date.now() + 5000; share <= 0.5 && Date.now() < end; await page.waitForTimeout(50)) share = await least_wet();
  assert.ok(share > 0.5, `of the texels at one place only ${share} are wet`);
  await page.mouse.up();
  await until(page, (end) => !window.patinate.status().painting && window.patinate.status().iteration > end, at);
  await in_page(() => window.patinate.send("pause"));
  await until(page, () => window.patinate.status().running === false);
  const painted = await same_planes(), then = await iteration();
  await page.keyboard.press("p");
  const is_back = (can_redo) => until(page, ([end, has_redo]) => { const s = window.patinate.status(); return s.iteration === end && !s.running && s.can_redo === has_redo; }, [then, can_redo]);
  await page.keyboard.press("Control+z");
  await is_back(true);  // The iterations since are done again without it.
  const never_painted = await same_planes();
  assert.notEqual(never_painted, painted);
  await page.keyboard.press("Control+Shift+Z");
  await is_back(false);
  assert.equal(await same_planes(), painted);
  await page.getByRole("button", { name: "Undo" }).click();
  await is_back(true);
  await page.keyboard.press("Control+y");
  await is_back(false);
  assert.equal(await same_planes(), painted);
  await page.keyboard.press("Control+Z");  // Caps Lock.
  await is_back(true);
  assert.equal(await same_planes(), never_painted);
  assert.ok(at >= from && (await page.getByRole("button", { name: "Redo" }).isEnabled()));
  assert.notEqual(start, never_painted, "time went on");
});

test("a setting is undone without losing an iteration, from the keyboard and from the list of steps", async () => {
  const field = page.getByRole("textbox", { name: "Ratio r: washes or deposits" });
  const ratio = () => in_page(() => window.patinate.scene().exchange.ratio);
  const before = await ratio();
  await field.click();
  await page.keyboard.type("0,85");
  await page.keyboard.press("Enter");
  await until(page, () => window.patinate.scene().exchange.ratio === 0.85);
  await run_for(8);
  const then = await iteration();
  assert.match(await page.locator(".steps-done [aria-current]").textContent(), /Ratio 0\.85/);
  await field.focus();
  await page.keyboard.press("Control+z");  // Nothing is typed in the field: the scene's.
  await until(page, (value) => window.patinate.scene().exchange.ratio === value, before);
  assert.equal(await iteration(), then);
  assert.equal(await field.inputValue(), String(before));
  await page.locator(".steps-done .undone button", { hasText: "Ratio 0.85" }).click();
  await until(page, () => window.patinate.scene().exchange.ratio === 0.85);
  await page.locator(".steps-done button", { hasText: "Before all these" }).click();
  await until(page, () => window.patinate.status().can_undo === false);
  await until(page, (end) => window.patinate.status().iteration === end && !window.patinate.status().running, then);
  assert.equal(await ratio(), before);
  assert.equal(await iteration(), then);
  await same_planes();
});

test("the brush carries any material, as much as is asked for, and an eraser takes it away again", async () => {
  const brush = () => in_page(() => window.patinate.scene().emitters.find((e) => e.name === "brush").carries);
  const painting = page.locator("details", { has: page.locator("summary", { hasText: "Paint on the surface" }) });
  await painting.locator("select", { hasText: "spout" }).selectOption("brush");
  await painting.locator("select", { hasText: "moss" }).selectOption("moss");
  await until(page, () => { const c = window.patinate.scene().emitters.find((e) => e.name === "brush").carries; return c.moss > 0 && c.water === 0 && c.dirt === 0; });
  const flow = painting.getByRole("textbox", { name: "Flow" });
  await flow.click();
  await page.keyboard.type("3");
  await page.keyboard.press("Enter");
  await until(page, () => window.patinate.scene().emitters.find((e) => e.name === "brush").carries.moss === 3);
  assert.equal((await brush()).moss, 3);
  await in_page(() => window.patinate.send("event", { event: { op: "rate", target: "moss", rate: 0.5 } }));
  const moss = () => in_page(() => window.patinate.status().ledger.moss.on_surfaces);
  const stroke = async () => {
    await page.mouse.move(420, 500);
    await page.mouse.down();
    await until(page, () => window.patinate.status().painting);
    for (let x = 430; x <= 600; x += 10) await page.mouse.move(x, 502);
    await page.mouse.up();
    await until(page, () => window.patinate.status().painting === false);
  };
  const none = await moss(), at = await iteration();
  // By its button: a focused field would take the key, and the mode may still be on.
  const mode = page.locator("button[aria-pressed]", { hasText: /^Paint/ }).first();
  const set_mode = async (is_on) => {
    if ((await mode.getAttribute("aria-pressed")) !== String(is_on)) await mode.click();
  };
  await set_mode(true);
  await stroke();
  const laid = await moss();
  assert.ok(laid > none, `${laid} of moss`);
  await painting.getByRole("radio", { name: "Erase" }).click();
  await painting.locator("select", { hasText: "everything" }).selectOption("moss");
  await stroke();
  const left = await moss();
  assert.ok(left < 0.6 * laid, `${left} of ${laid} are left`);
  assert.equal(await iteration(), at, "neither takes time");
  assert.match(await page.locator(".steps-done [aria-current]").textContent(), /Erase with brush/);
  await page.keyboard.press("Control+z");
  await until(page, (amount) => Math.abs(window.patinate.status().ledger.moss.on_surfaces / amount - 1) < 1e-6, laid);
  await painting.getByRole("radio", { name: "Paint" }).click();
  await set_mode(false);
  await same_planes();
});

test("a place of a running scene has all its numbers, and their curve once it runs", async () => {
  await page.locator(".thing button", { hasText: "wall" }).focus();
  await page.mouse.click(500, 420);
  const panel = page.locator("details", { has: page.locator("summary", { hasText: "Values of a place" }) });
  await panel.locator("dd").first().waitFor();
  assert.match(await panel.locator("dl").textContent(), /water[\d.]+.*height-?[\d.]+ mmL\*/);
  await run_for(30);
  await panel.locator("select", { hasText: "color" }).selectOption("color");
  await panel.locator(".chart").waitFor();
  const [file] = await Promise.all([page.waitForEvent("download"), panel.getByRole("button", { name: "Save as CSV" }).click()]);
  const [head, ...rows] = (await readFile(await file.path(), "utf8")).trim().split("\n");
  assert.match(head, /^iteration,time \(d\),water \(amount\),.*height \(mm\)/);
  assert.ok(rows.length >= 2);
  await panel.getByRole("button", { name: "Let go" }).click();
});

test("the way back to the start is asked for, and can be undone", async () => {
  const before = await same_planes(), from = await iteration();
  assert.ok(from > 0);
  const back = page.getByRole("button", { name: "Back to the start" });
  await back.click();
  await page.locator("dialog").getByRole("button", { name: "Cancel" }).click();
  assert.equal(await iteration(), from);
  await back.click();
  assert.match(await page.locator("dialog").textContent(), new RegExp(`iteration ${from}`));
  await page.locator("dialog").getByRole("button", { name: "Back to the start" }).click();
  await until(page, () => window.patinate.status().iteration === 0);
  await page.keyboard.press("Control+z");
  await until(page, (end) => window.patinate.status().iteration === end, from);
  assert.equal(await same_planes(), before);
});

test("a paused scene is not called running, and its counters are there on the first look", async () => {
  await until(page, () => document.querySelector(".run-bar .state").textContent === "paused");
  assert.ok(!/running/i.test(await page.locator(".panel-head").textContent()));
  assert.equal(await page.locator(".ledger td").count(), 0);
  await page.locator("summary", { hasText: "Counters and mass" }).click();
  await until(page, () => document.querySelectorAll(".ledger td").length > 0);
  assert.match(await page.locator(".facts", { hasText: "emitted" }).textContent(), /emitted[1-9]/);
  await page.locator("summary", { hasText: "Counters and mass" }).click();
});

test("what a run has done is told for each object when it rests", async () => {
  await page.locator("summary", { hasText: "What it has done" }).click();
  const panel = page.locator("details", { has: page.locator("summary", { hasText: "What it has done" }) });
  await panel.locator("td").first().waitFor();
  const text = await panel.textContent();
  assert.match(text, /After \d+ iterations/);
  assert.match(text, /Changed by [\d.]+ ΔE/);
  assert.match(text, /water/);
  await page.locator("summary", { hasText: "What it has done" }).click();
});

test("the colors of amounts and counters span what is there, with numbers and a unit beside them", async () => {
  for (const name of ["water", "hits"]) {
    await page.locator("select", { hasText: "nothing" }).selectOption(name);
    const overlay = await until(page, (n) => { const o = window.patinate.scene().overlays.find((one) => one.name === n); return o.most > 0 && o.range[1] > 0 ? o : undefined; }, name);
    const plane = await until(page, () => { const { data } = window.patinate.planes().overlay; let most = 0; for (const b of data) if (b > most) most = b; return most; });
    // The largest byte is the largest value: bytes hold its root.
    assert.ok(Math.abs(overlay.high * (plane / 255) ** 2 / overlay.most - 1) < 0.02, JSON.stringify({ overlay, plane }));
    assert.ok(overlay.most > overlay.high / 4 && overlay.range[1] <= overlay.most, JSON.stringify(overlay));
    const text = await page.locator(".legend").textContent();
    assert.match(text, name === "water" ? /water \(amount\)/ : /hits \(1\/mm2\)/);
    const said = Number(/0([\d.]+)(?: and more|$)/.exec(text.replace(/^.*\)/, ""))?.[1]);
    assert.ok(Math.abs(said / overlay.range[1] - 1) < 0.01, `${text}: ${overlay.range[1]}`);
  }
  await page.locator("select", { hasText: "nothing" }).selectOption("water");
});

test("messages wrap, leave the picture where it is and uncovered, can be closed, and go when their cause is gone", async () => {
  const long = `missing_${"folder_without_a_place_to_break_".repeat(12)}/scene.json`;
  const box_of = (selector) => page.locator(selector).first().boundingBox();
  for (const width of [1280, 420]) {
    await page.setViewportSize({ width, height: 720 });
    const before = await box_of(".stage");
    await page.locator("select", { hasText: "nothing" }).evaluate(() => { window.patinate.live.events.problem(`/data/${"a_long_name_".repeat(30)}: is wrong`); });
    await until(page, () => document.documentElement.style.getPropertyValue("--notices") === `${document.querySelector(".notices").offsetHeight}px`);
    const notice = await box_of(".notices");
    assert.ok(notice.x >= 0 && notice.x + notice.width <= width, `${JSON.stringify(notice)} in ${width}`);
    assert.ok(await in_page(() => [...document.querySelectorAll(".notice span")].every((s) => s.scrollWidth <= s.clientWidth + 1)), "nothing runs out of it");
    assert.deepEqual(await box_of(".stage"), before, "the picture stays");
    for (const other of [".stage", ".run-bar", ".top"]) {
      const box = await box_of(other);
      const is_apart = notice.y + notice.height <= box.y + 0.5 || box.y + box.height <= notice.y + 0.5 || box.x + box.width <= notice.x + 0.5;
      assert.ok(is_apart, `${other} ${JSON.stringify(box)} lies under ${JSON.stringify(notice)}`);
    }
    // All of the panel can be scrolled to above it.
    await page.locator(".panel").evaluate((panel) => { panel.scrollTop = panel.scrollHeight; });
    const end = await page.getByRole("button", { name: "Export" }).boundingBox();
    assert.ok(end.y + end.height <= notice.y + 0.5, `${JSON.stringify(end)} and ${JSON.stringify(notice)}`);
    await page.locator(".panel").evaluate((panel) => { panel.scrollTop = 0; });
    await page.locator(".notice button").first().click();
    assert.equal(await page.locator(".notice").count(), 0);
  }
  await page.setViewportSize({ width: 1280, height: 720 });
  await in_page((path) => window.patinate.send_shown("save", { path }), long);  // The folder is not there.
  await page.waitForSelector(".notice.error");
  await in_page(() => window.patinate.send_shown("save", { path: `saved_${Date.now()}.json` }));
  await page.waitForSelector(".notice.error", { state: "detached" });
  await in_page(() => window.patinate.send_shown("fly"));
  await page.waitForSelector(".notice.error");
  await in_page(() => { location.hash = "#/history"; });  // Another page has other causes.
  await history_is_ready(page);
  assert.equal(await page.locator(".notice.error").count(), 0);
  await open_place(page, server, "wall/scene.json");
  await scene_is_ready(page);
});

nightly("a scene that cannot be opened says why, and nobody tries again", async () => {
  const scene = JSON.parse(await readFile(join(folder, "wall/scene.json"), "utf8"));
  await writeFile(join(folder, "wall/broken.json"), JSON.stringify({ ...scene, objects: [{ name: "wall", mesh: "missing.obj" }] }));
  const other = await new_page(context);
  let num_tries = 0;
  other.on("websocket", () => { ++num_tries; });
  await open_place(other, server, "wall/broken.json");
  await other.waitForSelector(".failure");
  assert.match(await other.locator(".failure").textContent(), /missing\.obj/);
  assert.equal(await other.locator(".progress").count(), 0, "the bar has ended");
  const tries = num_tries;
  await other.waitForTimeout(2500);
  assert.equal(num_tries, tries);
  assert.equal(await other.locator(".notice").count(), 0);
  assert.ok(!/trying again/.test(await other.locator("body").textContent()));
  await other.close();
});

test("post-controls recompose at once and simulate nothing", async () => {
  const start = await same_planes();
  const from = await iteration();
  await in_page(() => window.patinate.send("appearance", { appearance: { dirt: { strength: 2.5 } } }));
  assert.notEqual(await same_planes(), start);
  assert.equal(await iteration(), from);
});

/// Moves the slider with this label as a hand does, to a value.
const slide = (label, value) => in_page(([text, v]) => {
  const input = document.getElementById([...document.querySelectorAll(".panel label")].find((l) => l.textContent === text).htmlFor);
  input.value = String(v);
  input.dispatchEvent(new Event("input", { bubbles: true }));
}, [label, value]);

test("rules and the flow change while the scene runs", async () => {
  await in_page(() => window.patinate.send("reset"));
  await page.locator("summary", { hasText: "Rules of aging" }).click();
  await in_page(() => window.patinate.send("run"));
  await page.locator("select", { hasText: "another rule" }).selectOption("wetting");
  await until(page, () => window.patinate.scene().rules.at(-1).name === "wetting");
  await slide("Rate", 1.5);  // Of the first rule, evaporation.
  await slide("From bouncing to creeping", 0.9);
  await slide("Absorbed at a hit", 0.25);
  await until(page, () => { const s = window.patinate.scene(); return s.rules[0].rate === 1.5 && s.slider === 0.9 && s.behavior.absorb === 0.25 && s.behavior.bounce === 0; });
  assert.ok(await in_page(() => window.patinate.status().running));
  const from = await iteration();
  await until(page, (end) => window.patinate.status().iteration >= end, from + 40);
  await in_page(() => window.patinate.send("pause"));
  await same_planes();
  assert.ok((await in_page(() => window.patinate.status().ledger.water.made)) > 0, "the new rule makes water");
  await page.locator("summary", { hasText: "Rules of aging" }).click();
});

test("a finished simulation opens where it ended, says so, and changes its look at once", async () => {
  await open_place(page, server, "wet", "live");
  await scene_is_ready(page);
  await until(page, () => [...document.querySelectorAll("[role=status], [role=alert], .notice")].some((e) => /This is where the simulation ended, after 60 iterations/.test(e.textContent)));
  const end = await same_planes();
  assert.equal(await iteration(), 60);
  await in_page(() => window.patinate.send("appearance", { appearance: { water: { strength: 2.5 }, dirt: { variation: 0.9 } } }));
  assert.notEqual(await same_planes(), end);
  assert.equal(await iteration(), 60);
  await run_for(3);
  await open_place(page, server, "wall/scene.json");
  await scene_is_ready(page);
});

nightly("two browsers see the same scene", async () => {
  const second = await new_page(context);
  await open_place(second, server, "wall/scene.json");
  await scene_is_ready(second);
  await until(second, () => window.patinate.status()?.clients === 2);
  await run_for(5);
  assert.equal(await same_planes(second), await same_planes(page));
  assert.deepEqual(second.problems, []);
  await second.close();
});

test("an export can be downloaded file by file and as a whole, and its GLB opens with its textures", async () => {
  await page.getByRole("button", { name: "Export" }).click();
  await page.locator("dialog input[type=text]").fill("exported");
  await page.locator("dialog").getByRole("button", { name: "Save" }).click();
  await page.locator("dialog .files a").first().waitFor();
  const names = await page.locator("dialog .files a").allTextContents();
  for (const name of ["model.glb", "color.png", "height.exr", "scene.json", "controls/hits.exr"]) assert.ok(names.includes(name), `${name} of ${names}`);
  for (const name of names) {
    const [file] = await Promise.all([page.waitForEvent("download"), page.locator("dialog .files a", { hasText: new RegExp(`^${name.replace(".", "\\.")}$`) }).click()]);
    assert.deepEqual(await readFile(await file.path()), await readFile(join(folder, "exported", name)), name);
  }
  const [zip] = await Promise.all([page.waitForEvent("download"), page.locator("dialog").getByRole("button", { name: "Download all" }).click()]);
  assert.equal(zip.suggestedFilename(), "exported.zip");
  const listed = execFileSync("python3", ["-m", "zipfile", "-l", await zip.path()], { encoding: "utf8" });
  for (const name of names) assert.ok(listed.includes(`exported/${name}`), `${name} in ${listed}`);
  const glb = join(folder, "exported", "model.glb");
  const validator = fileURLToPath(new URL("../gltf/", import.meta.url));
  if (existsSync(join(validator, "node_modules"))) execFileSync(process.execPath, [join(validator, "validate.mjs"), glb]);
  await page.locator("dialog").getByText("Look at the model").click();
  await until(page, () => window.patinate?.view === "mesh" && window.patinate.is_ready());
  const materials = await in_page(() => {
    const found = [];
    window.patinate.viewer.content.traverse((o) => { if (o.isMesh) found.push({ color: o.material.map?.image?.width ?? 0, roughness: o.material.roughnessMap !== null, normal: o.material.normalMap !== null }); });
    return found;
  });
  assert.ok(materials.length > 0 && materials.every((m) => m.color === 256 && m.roughness && m.normal), JSON.stringify(materials));
  await open_place(page, server, "wall/scene.json");
  await scene_is_ready(page);
});

test("the first stop of Tab is Run, the second one a step", async () => {
  await page.keyboard.press("Tab");
  assert.equal(await in_page(() => document.activeElement.textContent), "Run");
  await page.keyboard.press("Tab");
  assert.equal(await in_page(() => document.activeElement.getAttribute("aria-label")), "One step");
});

test("when the server was killed and started again, the page comes back, and what was painted with it", async () => {
  const { port } = server;
  const surface = async () => { const { server: there } = await in_page(() => window.patinate.check_hash()); return there.surface + there.material; };
  const painted = await surface(), end = await iteration();
  assert.equal(await page.locator(".notice.offer").count(), 0);
  await page.waitForTimeout(1000);  // By then it is on the disk.
  await server.kill();
  await page.waitForSelector(".notice[data-about=connection]");
  assert.match(await page.locator(".notice[data-about=connection]").textContent(), /connection is lost/);
  server = await serve(program, folder, port);
  // A new start has a new token: opening its address gives this browser the new cookie.
  const other = await new_page(context);
  await other.goto(server.address);
  await other.close();
  await page.waitForSelector(".notice[data-about=connection]", { state: "detached" });
  await until(page, () => window.patinate.status()?.iteration === 0);
  const offered = page.locator(".notice.offer");
  await offered.waitFor();
  assert.match(await offered.textContent(), new RegExp(`Resume what was painted \\(${end} iterations, saved `));
  assert.notEqual(await surface(), painted, "it is offered, not done");
  await offered.getByRole("button", { name: "Resume" }).click();
  await until(page, (at) => window.patinate.status().iteration === at && !window.patinate.status().running, end);
  assert.equal(await offered.count(), 0);
  assert.equal(await surface(), painted);
  await run_for(5);
  await same_planes();
});

test("nothing went wrong unseen", () => {
  assert.deepEqual(page.problems, []);
});
