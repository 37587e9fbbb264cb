// What the browser tests, the screenshots and the measurements share: small data, a server, a browser.
import { execFile, spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { promisify } from "node:util";

const run_file = promisify(execFile);
export const kChromium = process.env.PATINATE_CHROMIUM ?? "/usr/bin/chromium";
const kReady_ms = 60000;

/// Why the browser cannot be tested here, "" if it can.
export function missing() {
  if (!existsSync(kChromium)) return `${kChromium} is missing (tools/setup --tests installs it)`;
  if (!existsSync(new URL("./node_modules/playwright-core", import.meta.url))) return "tests/studio/node_modules is missing (tools/setup --tests installs it)";
  return "";
}

export async function patinate(program, folder, ...parameters) {
  await run_file(program, [...parameters, "--quiet"], { cwd: folder });
}

/// A scene file of `synth ledge`, smaller and with an emitter that can be moved and one to paint with.
export async function edit_scene(file, change) {
  const scene = JSON.parse(await readFile(file, "utf8"));
  change(scene);
  await writeFile(file, JSON.stringify(scene, null, 2));
}

/// A wall with a spout before its left half and a brush; nothing else rains. `sky`: it rains everywhere instead.
export async function make_wall(program, folder, { resolution = 256, gammatons = 400, name = "wall", sky = false } = {}) {
  await patinate(program, folder, "synth", "ledge", "-o", name, "--cells", "10");
  await edit_scene(join(folder, name, "scene.json"), (scene) => {
    scene.atlas.resolution = resolution;
    scene.run = { iterations: 60, history_every: 20, controls: ["hits"] };
    scene.emitters = [
      { name: "spout", shape: "disk", position: [-200, 250, 300], direction: [0, 0, -1], size: 120, spread_deg: 2, speed: 20000, gammatons, carries: { water: 2, dirt: 0.3 } },
      { name: "brush", shape: "surface", position: [0, 0, 0], size: 100, distance: 30, speed: 500, gammatons, carries: { water: 2, dirt: 2 }, on: false },
    ];
    if (sky) scene.emitters[0] = { name: "spout", shape: "sky", direction: [0, -1, -0.12], spread_deg: 4, speed: 3000, gammatons, carries: { water: 0.8, dirt: 0.3 } };
  });
}

/// `patinate studio`, until close() or kill().
export async function serve(program, folder, port = 0) {
  const process_ = spawn(program, ["studio", folder, "--json", "--port", String(port)], { stdio: ["ignore", "pipe", "pipe"] });
  let said = "", wrong = "";
  process_.stderr.on("data", (data) => { wrong += data; });
  const ended = new Promise((resolve) => process_.once("exit", resolve));
  await new Promise((resolve, reject) => {
    process_.once("exit", () => reject(new Error(`studio ended: ${wrong}`)));
    createInterface({ input: process_.stdout }).on("line", (line) => {
      said += line;
      if (line.startsWith("}")) resolve();
    });
  });
  const { port: bound, token } = JSON.parse(said);
  const base = `http://127.0.0.1:${bound}`;
  return {
    port: bound, token, base, address: `${base}/?token=${token}`, pid: process_.pid,
    get: (path, headers = {}) => fetch(base + path, { headers: { Authorization: `Bearer ${token}`, ...headers } }),
    kill: async () => { process_.kill("SIGKILL"); await ended; },
    close: async () => { process_.kill("SIGTERM"); await ended; },
  };
}

export async function open_browser(options = {}) {
  const { chromium } = createRequire(import.meta.url)("playwright-core");
  const browser = await chromium.launch({ executablePath: kChromium, args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--js-flags=--expose-gc", ...(options.args ?? [])] });
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "dark", acceptDownloads: true, ...options.context });
  return { browser, context };
}

/// A page whose errors are kept in page.problems. PATINATE_STUDIO_CLIENT: a folder with a bundle of build.mjs to try in place of the program's.
export async function new_page(context) {
  const page = await context.newPage();
  const client = process.env.PATINATE_STUDIO_CLIENT;
  for (const file of client ? ["studio.js", "studio.css"] : []) await page.route(`**/${file}`, (route) => route.fulfill({ path: join(client, file) }));
  page.problems = [];
  page.on("pageerror", (error) => page.problems.push(error.message));
  page.setDefaultTimeout(kReady_ms);
  return page;
}

export async function open_place(page, server, place, mode = "") {
  await page.goto(`${server.base}/#/${encodeURIComponent(place)}${mode ? `?${mode}` : ""}`);
  await page.reload();
}

/// Until f(argument) holds in the page. Not waitForFunction(), which the page's security policy forbids.
export async function until(page, f, argument, limit_ms = kReady_ms) {
  for (const end = Date.now() + limit_ms; Date.now() < end;) {
    const value = await page.evaluate(f, argument).catch(() => undefined);  // The page may be loading.
    if (value) return value;
    await new Promise((resolve) => setTimeout(resolve, 40));
  }
  throw new Error(`not within ${limit_ms / 1000} s: ${f}`);
}

/// A history, transfer or simulation is on screen, and nothing lies over it.
export async function history_is_ready(page) {
  await until(page, () => window.patinate?.view === "history" && window.patinate.texture_hash() && !document.querySelector(".progress"));
}

/// A scene is on screen: its mesh and its first texels.
export async function scene_is_ready(page) {
  await until(page, () => window.patinate?.view === "simulation" && window.patinate.is_ready());
}

/// A sky with a sun of 5 degrees: 128 x 64, RGBE in rows that are not compressed.
export async function write_sky(file) {
  const width = 128, height = 64, bytes = Buffer.alloc(4 * width * height), sun = { u: 0.3, up: 50 };
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const up = 90 - (180 * (y + 0.5)) / height, across = ((x + 0.5) / width - sun.u) * 360 * Math.cos((up * Math.PI) / 180);
      const color = Math.hypot(up - sun.up, across) < 5 ? [60, 55, 45] : up > 0 ? [0.5 - 0.003 * up, 0.6 - 0.001 * up, 0.7 + 0.002 * up] : [0.2, 0.18, 0.15];
      const exponent = Math.floor(Math.log2(Math.max(...color))) + 1;
      bytes.set([...color.map((v) => Math.min(255, Math.round((v / 2 ** exponent) * 256))), exponent + 128], 4 * (y * width + x));
    }
  }
  await writeFile(file, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), bytes]));
}
