// node measure.mjs PATINATE [seconds of the memory run]: how fast a running scene reaches the browser, and whether memory stays flat. Prints JSON lines.
// Software rendering: simulation, server and browser share the machine's cores, as on a lab machine without a GPU.
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { make_wall, missing, new_page, open_browser, open_place, scene_is_ready, serve, until } from "./support.mjs";

const program = resolve(process.argv[2]);
const memory_s = Number(process.argv[3] ?? 180);
const only = Number(process.argv[4] ?? 0);  // One resolution.
/// Resolution, and gammatons so that an iteration makes about a tenth of the tiles dirty.
const kScenes = [[1024, 1500], [2048, 5000]];
const kTicks_s = 100;  // Of /proc.
const kUpdates_s = 10, kNumStrokes = 9;
const why = missing();
if (why) throw new Error(why);

const folder = await mkdtemp(join(tmpdir(), "patinate-measure-"));
const say = (what) => console.log(JSON.stringify(what));
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const server_mb = async (pid) => Number(/VmRSS:\s+(\d+)/.exec(await readFile(`/proc/${pid}/status`, "utf8"))[1]) / 1024;
const load = async () => Number((await readFile("/proc/loadavg", "utf8")).split(" ")[0]);

/// Seconds of processor time that a process and all its children have had: what an update costs, whatever else the machine does.
async function cpu_s(root) {
  const children = new Map(), times = new Map();
  for (const name of await readdir("/proc")) {
    if (!/^\d+$/.test(name)) continue;
    const text = await readFile(`/proc/${name}/stat`, "utf8").catch(() => "");
    const fields = text.slice(text.lastIndexOf(")") + 2).split(" ");
    if (fields.length < 15) continue;
    children.set(Number(fields[1]), [...(children.get(Number(fields[1])) ?? []), Number(name)]);
    times.set(Number(name), (Number(fields[11]) + Number(fields[12])) / kTicks_s);
  }
  const sum = (pid) => (times.get(pid) ?? 0) + (children.get(pid) ?? []).reduce((all, child) => all + sum(child), 0);
  return sum(root);
}

/// Updates per second on screen, and the share of tiles that an update carries (of the surface and the relief together).
async function updates(page, server, seconds) {
  const counts = () => page.evaluate(() => { const p = window.patinate.planes(); return { updates: p.num_updates, tiles: p.num_tiles, all: Math.ceil(p.width / 8) * Math.ceil(p.height / 8), iteration: window.patinate.status().iteration, now: performance.now() }; });
  const cpu = async () => ({ server: await cpu_s(server.pid), all: await cpu_s(process.pid) });  // The server and the browser are children of this process.
  const a = await counts(), busy_a = await cpu();
  await sleep(1000 * seconds);
  const b = await counts(), busy_b = await cpu();
  const s = (b.now - a.now) / 1000, n = b.updates - a.updates;
  return { updates_per_s: n / s, iterations_per_s: (b.iteration - a.iteration) / s, dirty_share: (b.tiles - a.tiles) / Math.max(1, n) / b.all / 2,
    server_cpu_ms: (1000 * (busy_b.server - busy_a.server)) / n, browser_cpu_ms: (1000 * (busy_b.all - busy_a.all - (busy_b.server - busy_a.server))) / n };
}

/// From pressing the button to the first changed texel under it, on screen, ms: median of several places.
async function stroke_latency(page) {
  await page.keyboard.press("p");
  const all = [];
  for (let i = 0; i < kNumStrokes; ++i) {
    const at = { x: 270 + 10 * i, y: 290 - 8 * i };
    await page.mouse.move(at.x, at.y);
    const measured = page.evaluate(({ x, y }) => new Promise((resolve) => {
      const { viewer, planes } = window.patinate;
      const { uv } = viewer.pick(x, y);
      const plane = planes().surface, reach = Math.ceil(plane.width / 64);
      const cut = () => {
        const cx = Math.floor(uv.x * plane.width), cy = Math.floor(uv.y * plane.height);
        let text = "";
        for (let j = -reach; j <= reach; ++j) for (let k = -reach; k <= reach; ++k) text += plane.data[4 * ((cy + j) * plane.width + cx + k)] + ",";
        return text;
      };
      const before = cut();
      let pressed = Infinity;
      viewer.canvas.addEventListener("pointerdown", () => { pressed = performance.now(); }, { once: true });
      const after_frame = viewer.after_frame;
      viewer.after_frame = () => {
        after_frame();
        if (performance.now() < pressed || cut() === before) return;
        viewer.after_frame = after_frame;
        resolve(performance.now() - pressed);
      };
    }), at);
    await sleep(100);
    await page.mouse.down();
    all.push(await Promise.race([measured, sleep(5000).then(() => NaN)]));
    await page.mouse.up();
    await sleep(300);
  }
  await page.keyboard.press("p");
  const sorted = all.filter((v) => !Number.isNaN(v)).sort((a, b) => a - b);
  return { median_ms: sorted[Math.floor(sorted.length / 2)], worst_ms: sorted.at(-1), num: sorted.length };
}

/// Stroke after stroke over the wall while it continues running. @returns how many.
async function paint(page, seconds) {
  await page.keyboard.press("p");
  let count = 0;
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; ++count) {
    const x = 230 + (37 * count) % 120, y = 180 + (53 * count) % 140;
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= 10; ++i) {
      await page.mouse.move(x + 8 * i, y + 20 * Math.sin(i));
      await sleep(40);
    }
    await page.mouse.up();
    await sleep(600);
  }
  await page.keyboard.press("p");
  return count;
}

const heap_mb = async (client) => {
  await client.send("HeapProfiler.collectGarbage");
  const { metrics } = await client.send("Performance.getMetrics");
  return metrics.find((m) => m.name === "JSHeapUsedSize").value / 2 ** 20;
};

try {
  for (const [resolution, gammatons] of kScenes.filter(([r]) => only === 0 || r === only)) {
    const name = `wall${resolution}`;
    await make_wall(program, folder, { resolution, gammatons, name, sky: true });
    const server = await serve(program, folder);
    const { browser, context } = await open_browser({ context: { viewport: { width: 980, height: 510 } } });  // A picture of 640 x 400.
    const page = await new_page(context);
    await page.goto(server.address);
    await open_place(page, server, `${name}/scene.json`);
    await scene_is_ready(page);
    const paused = await stroke_latency(page);
    for (const iterations of [1, 0]) {  // One iteration for every picture, as the paper's loop; and as fast as the server can.
      await until(page, () => window.patinate.status().running === false);
      await sleep(500);
      await page.evaluate((n) => { window.patinate.set_pace(n); window.patinate.toggle_run(); }, iterations);
      await sleep(3000);
      say({ what: "updates", resolution, iterations_per_picture: iterations || "any", ...(await updates(page, server, kUpdates_s)), load: await load() });
      if (iterations > 0) await page.evaluate(() => window.patinate.toggle_run());
    }
    say({ what: "stroke", resolution, starts: "paused", ...paused, load: await load() });
    say({ what: "stroke", resolution, starts: "running", ...(await stroke_latency(page)), load: await load() });
    if (resolution === 1024 && memory_s > 0) {
      const client = await context.newCDPSession(page);
      await client.send("Performance.enable");
      const step_s = Math.max(10, memory_s / 6);
      for (let s = 0, num_strokes = 0; s <= memory_s; s += step_s) {
        const { iteration } = await page.evaluate(() => window.patinate.status());
        say({ what: "memory", seconds: s, strokes: num_strokes, iteration, browser_heap_mb: await heap_mb(client), server_mb: await server_mb(server.pid) });
        num_strokes += s + step_s <= memory_s ? await paint(page, step_s) : 0;
      }
    }
    await browser.close();
    await server.close();
  }
} finally {
  await rm(folder, { recursive: true, force: true });
}
