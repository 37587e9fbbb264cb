// node landmarks_test.mjs PATINATE: points clicked in photographs beside each other, in a real browser. Exit code 77: skipped.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { deflateSync } from "node:zlib";
import { missing, new_page, open_browser, open_place, serve, until } from "./support.mjs";

const program = process.argv[2];
const why = missing();
if (why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const folder = await mkdtemp(join(tmpdir(), "patinate-landmarks-"));
let server, browser, context, page;

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; ++k) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/// An RGB picture of `code(x, y)`.
function png(width, height, code) {
  const chunk = (kind, data) => {
    const body = Buffer.concat([Buffer.from(kind), data]), ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length, 0);
    ends.writeUInt32BE(crc32(body), 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const head = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 2, 0, 0, 0]), rows = Buffer.alloc(height * (3 * width + 1));
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) rows.fill(code(x, y), y * (3 * width + 1) + 1 + 3 * x, y * (3 * width + 1) + 4 + 3 * x);
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

/// An animated GIF of gray pictures, each shown for a second. Codes of 8 bits start anew before they would need a ninth.
function gif(width, height, pictures) {
  const number = (value) => Buffer.from([value & 255, value >> 8]);
  const blocks = pictures.map((code) => {
    const codes = [];
    for (let i = 0; i < width * height; ++i) {
      if (i % 120 === 0) codes.push(128);
      codes.push(code(i % width, Math.floor(i / width)) >> 1);
    }
    codes.push(129);
    const parts = [];
    for (let i = 0; i < codes.length; i += 255) parts.push(Buffer.from([Math.min(255, codes.length - i)]), Buffer.from(codes.slice(i, i + 255)));
    return Buffer.concat([Buffer.from([0x21, 0xf9, 4, 0, 100, 0, 0, 0, 0x2c, 0, 0, 0, 0]), number(width), number(height), Buffer.from([0, 7]), ...parts, Buffer.from([0])]);
  });
  const colors = Buffer.from(Array.from({ length: 384 }, (_, i) => 2 * Math.floor(i / 3)));
  return Buffer.concat([Buffer.from("GIF89a"), number(width), number(height), Buffer.from([0xf6, 0, 0]), colors, ...blocks, Buffer.from([0x3b])]);
}

// Three white spots on a plate, which the second photograph shows turned by a quarter: (x, y) is at (149 - y, x).
const kSpots = [[30, 40], [150, 50], [90, 120]];
const is_spot = (x, y) => kSpots.some(([a, b]) => Math.hypot(x - a, y - b) < 4);
const turned = ([x, y]) => [149 - y, x];

before(async () => {
  await mkdir(join(folder, "plate"));
  await writeFile(join(folder, "plate/a.png"), png(200, 150, (x, y) => (is_spot(x, y) ? 250 : 70)));
  await writeFile(join(folder, "plate/b.png"), png(150, 200, (x, y) => (is_spot(y, 149 - x) ? 230 : 50)));
  await writeFile(join(folder, "plate/capture.json"), JSON.stringify({ format: "patinate.capture", version: 1, name: "plate", kind: "fixed", align: "auto", align_to: "a.png", frames: { pattern: "*.png", interval: 1 } }));
  await mkdir(join(folder, "clip"));
  await writeFile(join(folder, "clip/clip.gif"), gif(200, 150, [(x, y) => (is_spot(x, y) ? 250 : 70), (x, y) => (is_spot(x - 20, y - 10) ? 230 : 50)]));
  await writeFile(join(folder, "clip/capture.json"), JSON.stringify({ format: "patinate.capture", version: 1, name: "clip", kind: "fixed", align: "auto", frames: { pattern: "clip.gif" } }));
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

const marks = () => page.evaluate(() => window.patinate.marks());
const on_page = (side, [x, y]) => page.evaluate(([s, a, b]) => window.patinate.on_page(s, a, b), [side, x, y]);
async function click(side, at) {
  const { x, y } = await on_page(side, at);
  await page.mouse.click(x, y);
}
const saved = () => readFile(join(folder, "plate/landmarks.csv"), "utf8");

/// Marks by "photo point", of whole pixels where a click is exact to one.
async function near(expected) {
  const found = await marks();
  assert.equal(found.length, Object.keys(expected).length, JSON.stringify(found));
  for (const { photo, point, x, y } of found) {
    const [a, b] = expected[`${photo} ${point}`];
    assert.ok(Math.hypot(x - a, y - b) < 1, `${photo} ${point}: ${x}, ${y}; expected ${a}, ${b}`);
  }
}

test("the message of an ingest that failed names the command that opens the studio", () => {
  assert.throws(() => execFileSync(program, ["ingest", "plate/capture.json", "-o", "out"], { cwd: folder, stdio: "pipe" }),
    (error) => /`patinate studio plate\/capture\.json`/.test(String(error.stderr)));
});

test("a capture leads to its photographs beside each other", async () => {
  await open_place(page, server, "plate");
  await page.getByRole("button", { name: "Mark points" }).click();
  await until(page, () => window.patinate?.view === "landmarks" && window.patinate.is_ready());
  assert.equal(await page.locator(".photo-pane").count(), 2);
  assert.match(await page.locator(".say").textContent(), /new place in the left photograph: point 1/);
});

test("clicks mark the same point in both, with one number", async () => {
  for (const spot of kSpots) {
    await click(0, spot);
    await click(1, turned(spot));
  }
  await near(Object.fromEntries(kSpots.flatMap((spot, i) => [[`0 ${i + 1}`, spot], [`1 ${i + 1}`, turned(spot)]])));
  assert.equal(await page.locator(".marker").count(), 6);
  assert.deepEqual(await page.locator(".photo-pane").first().locator(".marker span").allTextContents(), ["1", "2", "3"]);
});

test("a drag corrects a marker, and undo takes it back as a whole", async () => {
  const from = await on_page(0, kSpots[0]);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (const step of [10, 20, 30]) await page.mouse.move(from.x + step, from.y + step / 2);
  await page.mouse.up();
  const moved = (await marks()).find((m) => m.photo === 0 && m.point === "1");
  assert.ok(moved.x > kSpots[0][0] + 3 && moved.y > kSpots[0][1] + 1, JSON.stringify(moved));
  await page.keyboard.press("Control+z");
  await near(Object.fromEntries(kSpots.flatMap((spot, i) => [[`0 ${i + 1}`, spot], [`1 ${i + 1}`, turned(spot)]])));
});

test("the wheel zooms about the pointer, and a click then is finer", async () => {
  const before = await on_page(0, [90, 60]);
  await page.mouse.move(before.x, before.y);
  for (let i = 0; i < 6; ++i) await page.mouse.wheel(0, -240);
  // A wheel's place is in whole pixels of the page; half of one is five at ten times the size.
  await until(page, ([x, y]) => { const a = window.patinate.on_page(0, 90, 60), b = window.patinate.on_page(0, 91, 60); return Math.hypot(a.x - x, a.y - y) < 8 && b.x - a.x > 15; }, [before.x, before.y]);
  await click(0, [90.3, 60.2]);
  const mark = (await marks()).find((m) => m.point === "4");
  assert.ok(Math.abs(mark.x - 90.3) < 0.11 && Math.abs(mark.y - 60.2) < 0.11, JSON.stringify(mark));
  await page.keyboard.press("ArrowRight");
  assert.ok(Math.abs((await marks()).find((m) => m.point === "4").x - mark.x - 1) < 1e-9);
  await page.keyboard.press("Delete");
  assert.equal((await marks()).length, 6);
  await page.keyboard.press("f");
});

test("points that are not saved yet are still there after a look elsewhere", async () => {
  await page.getByRole("button", { name: "Its photographs" }).click();
  await until(page, () => window.patinate?.view === "capture");
  await page.getByRole("button", { name: "Mark points" }).click();
  await until(page, () => window.patinate?.view === "landmarks" && window.patinate.is_ready());
  assert.equal((await marks()).length, 6);
  assert.ok(await page.evaluate(() => window.patinate.is_changed()));
});

test("saved points are in the project, and lay its photographs over one another", async () => {
  await page.getByRole("button", { name: "Save" }).click();
  await until(page, () => !window.patinate.is_changed());
  assert.match(await page.locator(".notice").last().textContent(), /6 marks are saved in landmarks\.csv/);
  assert.equal((await saved()).trim().split("\n").length, 7);
  assert.equal(JSON.parse(await readFile(join(folder, "plate/capture.json"), "utf8")).landmarks, "landmarks.csv");
  execFileSync(program, ["ingest", "plate/capture.json", "-o", "out", "--quiet"], { cwd: folder });
  const { photos } = JSON.parse(await readFile(join(folder, "out/alignment.json"), "utf8"));
  const [a, b, c, d, e, f] = photos[1].transform;
  for (const spot of kSpots) {
    const [x, y] = turned(spot);
    assert.ok(Math.hypot(a * x + b * y + c - spot[0], d * x + e * y + f - spot[1]) < 1.5, String(photos[1].transform));
  }
});

test("images of one file are marked as photographs are", async () => {
  await open_place(page, server, "clip");
  await page.getByRole("button", { name: "Mark points" }).click();
  await until(page, () => window.patinate?.view === "landmarks" && window.patinate.is_ready());
  for (const spot of kSpots) {
    await click(0, spot);
    await click(1, [spot[0] + 20, spot[1] + 10]);
  }
  await page.getByRole("button", { name: "Save" }).click();
  await until(page, () => !window.patinate.is_changed());
  execFileSync(program, ["ingest", "clip/capture.json", "-o", "clip_out", "--quiet"], { cwd: folder });
  const { photos } = JSON.parse(await readFile(join(folder, "clip_out/alignment.json"), "utf8"));
  const [a, b, c, d, e, f] = photos[0].transform;  // To the last one.
  for (const [x, y] of kSpots) assert.ok(Math.hypot(a * x + b * y + c - x - 20, d * x + e * y + f - y - 10) < 1.5, String(photos[0].transform));
  await open_place(page, server, "plate");
  await page.getByRole("button", { name: "Mark points" }).click();
  await until(page, () => window.patinate?.view === "landmarks" && window.patinate.is_ready());
});

test("a project that was changed meanwhile is not overwritten, and the page says so", async () => {
  const table = await saved();
  await writeFile(join(folder, "plate/landmarks.csv"), `${table}a.png,9,1,1\n`);
  await click(0, [20, 20]);
  await page.keyboard.press("Control+s");
  await page.waitForSelector(".notice.error");
  assert.match(await page.locator(".notice.error").textContent(), /was changed .* nothing was saved/);
  assert.equal(await saved(), `${table}a.png,9,1,1\n`);
  assert.ok(await page.evaluate(() => window.patinate.is_changed()));
});

test("nothing went wrong unseen", () => {
  assert.deepEqual(page.problems, []);
});
