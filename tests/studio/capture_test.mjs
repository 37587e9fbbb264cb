// node capture_test.mjs PATINATE: from photographs to repaired ones beside them, with real input events in a real browser: upload, crop, mask, scale, chart, ingest. Exit code 77: skipped.
import assert from "node:assert/strict";
import { mkdir, mkdtemp, readdir, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { history_is_ready, missing, new_page, open_browser, open_place, patinate, serve, until } from "./support.mjs";

const program = process.argv[2];
const why = missing();
if (why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const folder = await mkdtemp(join(tmpdir(), "patinate-capture-"));
const served = join(folder, "served");
let server, browser, context, page, photographs;

before(async () => {
  await mkdir(served);
  await patinate(program, folder, "synth", "crackle", "--width", "96", "--height", "80", "--num-frames", "4", "-o", "made");
  photographs = await Promise.all([0, 1, 2, 3].map(async (i) => ({ name: `Day ${i + 1} (north).png`, mimeType: "image/png", buffer: await readFile(join(folder, `made/frames/000${i}.png`)) })));
  server = await serve(program, served);
  ({ browser, context } = await open_browser());
  page = await new_page(context);
  await page.goto(server.address);
});

after(async () => {
  assert.deepEqual(page?.problems ?? [], []);
  await browser?.close();
  await server?.close();
  await rm(folder, { recursive: true, force: true });
});

const dialog = () => page.locator("dialog[open]");
const choose = async (files) => {
  const choosing = page.waitForEvent("filechooser");
  await dialog().getByRole("button", { name: "Choose photographs" }).click();
  await (await choosing).setFiles(files);
};
const project = async () => JSON.parse(await readFile(join(served, "paint/capture.json"), "utf8"));
const draft = () => page.evaluate(() => window.patinate.draft());
const num_outside = () => page.evaluate(() => window.patinate.num_outside());
const on_page = ([x, y], side) => page.evaluate(([a, b, s]) => (s === undefined ? window.patinate.on_page(a, b) : window.patinate.on_page(s, a, b)), [x, y, side]);
const click = async (at) => {
  const { x, y } = await on_page(at);
  await page.mouse.click(x, y);
};
const drag = async (...way) => {
  for (const [i, at] of way.entries()) {
    if (typeof at === "string") {
      await page.keyboard.press(at);
      continue;
    }
    const { x, y } = await on_page(at);
    await page.mouse.move(x, y, { steps: 4 });
    if (i === 0) await page.mouse.down();
  }
  await page.mouse.up();
};
const tool = (name) => page.getByRole("radio", { name, exact: true }).click();
const save = async () => {
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await until(page, () => !window.patinate.is_changed());
};

test("photographs are copied into a new folder, and the page says what init has found", async () => {
  await page.getByRole("button", { name: "Begin with photographs" }).click();
  await choose([...photographs, { name: "broken.png", mimeType: "image/png", buffer: Buffer.from("x") }, { name: "notes.txt", mimeType: "text/plain", buffer: Buffer.from("x") }]);
  assert.match(await dialog().locator(".summary").innerText(), /^5 photographs, .* MB; 1 other file is left out$/);
  await dialog().getByLabel("Name of the new folder").fill("../paint");
  await dialog().getByRole("button", { name: "Copy and look at them" }).click();
  await until(page, () => document.querySelector("dialog .problem")?.textContent !== "");
  assert.deepEqual(await readdir(served), []);
  await dialog().getByLabel("Name of the new folder").fill("paint");
  await dialog().getByRole("button", { name: "Copy and look at them" }).click();
  await until(page, () => document.querySelector("dialog .problem")?.textContent.includes("broken.png"));
  await dialog().getByRole("button", { name: "Leave it out" }).click();
  await page.waitForSelector(".capture .draft");
  assert.match(await page.locator(".draft").innerText(), /found\n4 photographs/);
  assert.deepEqual((await readdir(join(served, "paint"))).sort(), ["Day_1_north.png", "Day_2_north.png", "Day_3_north.png", "Day_4_north.png", "capture.hints.txt", "capture.json"]);
  assert.deepEqual(await readFile(join(served, "paint/Day_3_north.png")), photographs[2].buffer);
});

test("those that are dropped on the first page are offered, too, and no folder is used twice", async () => {
  await page.goto(`${server.base}/#/`);
  await page.waitForSelector(".card");
  const data = await page.evaluateHandle(([bytes, name]) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([Uint8Array.from(bytes)], name, { type: "image/png" }));
    return transfer;
  }, [[...photographs[0].buffer], "a.png"]);
  await page.dispatchEvent(".places", "drop", { dataTransfer: data });
  await dialog().waitFor();
  await dialog().getByLabel("Name of the new folder").fill("paint");
  await dialog().getByRole("button", { name: "Copy and look at them" }).click();
  await until(page, () => document.querySelector("dialog .problem")?.textContent.includes("exists"));
  await choose(Array.from({ length: 2001 }, (_, i) => ({ name: `${i}.png`, mimeType: "image/png", buffer: Buffer.from("x") })));
  assert.match(await dialog().locator(".problem").innerText(), /At most 2000 photographs/);
  assert.ok(await dialog().getByRole("button", { name: "Copy and look at them" }).isDisabled(), "not only the last is refused");
  await page.keyboard.press("Escape");
});

test("a rectangle crops, and the brush and a color make the mask; every step can be undone", async () => {
  await open_place(page, server, "paint");
  await page.getByRole("button", { name: "Crop, mask, scale" }).click();
  await until(page, () => window.patinate?.view === "prepare" && window.patinate.is_ready());
  await drag([7.5, 9.5], [40, 30], [71.5, 57.5]);
  assert.deepEqual((await draft()).roi, [8, 10, 64, 48]);
  await page.keyboard.press("Control+z");
  assert.equal((await draft()).roi, null);
  await drag([71.5, 57.5], [7.5, 9.5]);
  assert.deepEqual((await draft()).roi, [8, 10, 64, 48]);
  await tool("Mask");
  await page.getByLabel("Radius, px").fill("4");
  await page.keyboard.press("Enter");
  await drag([10, 20], [70, 20]);
  const stroke = await num_outside();
  assert.ok(stroke > 8 * 60 && stroke < 10 * 72, `a band 8 to 9 pixels wide, round at both ends: ${stroke}`);
  await drag([10, 40], [70, 40]);
  await page.keyboard.press("Control+z");
  assert.equal(await num_outside(), stroke);
  await drag([10, 40], "Control+z", [70, 40]);
  assert.ok((await num_outside()) > stroke, "a stroke that is not finished is not undone");
  await page.keyboard.press("Control+z");
  assert.equal(await num_outside(), stroke);
  await tool("Inside");
  await drag([10, 20], [70, 20]);
  assert.equal(await num_outside(), 0);
  await page.keyboard.press("Control+z");
  await tool("Outside");
  await tool("Color");
  await page.getByLabel("Tolerance", { exact: true }).last().fill("2");
  await click([60, 50]);
  const few = await num_outside();
  assert.ok(few > stroke);
  await page.locator(".tool-options input.number-field").fill("30");
  await page.keyboard.press("Enter");
  const more = await num_outside();
  assert.ok(more > few, "another tolerance takes the place of the last");
  await tool("Inside");
  assert.equal(await num_outside(), more, "what comes next is inside");
  await page.keyboard.press("Control+z");
  assert.equal(await num_outside(), stroke);
});

test("two places and a length are the scale, four corners the chart, and all of it is saved", async () => {
  await tool("Scale");
  await click([10, 40]);
  await click([60, 40]);
  const marker = await page.locator(".marker").first().boundingBox(), there = await on_page([10, 40]), ring = await page.evaluate(() => {
    const { left, top, width, height } = getComputedStyle(document.querySelector(".marker"), "::before"), border = 2 * 2;
    return [parseFloat(left) + (parseFloat(width) + border) / 2, parseFloat(top) + (parseFloat(height) + border) / 2];
  });
  assert.deepEqual(ring, [0, 0], "the ring is around the place");
  assert.ok(Math.hypot(marker.x - there.x, marker.y - there.y) < 1.5, "a click is exact to a pixel of the page");
  await page.getByLabel("Length in mm").fill("12,5");
  await page.keyboard.press("Enter");
  await until(page, () => window.patinate.draft().texel_size_mm !== null);
  assert.ok(Math.abs((await draft()).texel_size_mm - 0.25) < 0.25 * 0.02, "a click is exact to a pixel of the page");
  await tool("Chart");
  for (const at of [[2, 2], [40, 2], [40, 25], [2, 25]]) await click(at);
  assert.equal((await draft()).chart.corners.length, 4);
  await tool("None");
  assert.equal((await draft()).chart, null);
  await tool("Find it");
  assert.equal((await draft()).chart, "auto");
  const before_save = await num_outside();
  await save();
  let now = await project();
  assert.deepEqual([now.roi, now.mask, now.chart], [[8, 10, 64, 48], "masks/mask.png", "auto"]);
  assert.match(await page.getByLabel("The project's members").innerText(), /"roi": \[8, 10, 64, 48\],\n"mask": "masks\/mask.png",\n"texel_size_mm": 0\.2\d*,\n"chart": "auto"/);
  await tool("None");
  await save();
  now = await project();
  assert.equal(now.chart, undefined);
  await page.reload();
  await until(page, () => window.patinate?.view === "prepare" && window.patinate.is_ready());
  assert.equal(await num_outside(), before_save, "the mask is what it was");
});

test("what is set while the page saves stays set, and so does what is not saved when the page is left", async () => {
  let go;
  const held = new Promise((done) => { go = done; });
  await page.route("**/api/project?*", async (route) => {
    if (route.request().method() === "POST") await held;
    await route.continue();
  });
  await drag([20, 20], [60, 60]);
  await page.keyboard.press("Control+s");
  await drag([7.5, 9.5], [71.5, 57.5]);
  await page.keyboard.press("Control+s");
  go();
  await until(page, () => !document.querySelector(".prepare button.primary").disabled);
  assert.notDeepEqual((await project()).roi, [8, 10, 64, 48]);
  assert.equal(await page.locator(".notice.error").count(), 0, "nothing is saved twice at once");
  assert.deepEqual((await draft()).roi, [8, 10, 64, 48]);
  await page.unroute("**/api/project?*");
  await save();
  await tool("Mask");
  await drag([20, 70], [70, 70]);
  assert.ok(await page.locator(".job-buttons").evaluate(({ inert }) => inert), "a job reads what is saved");
  const outside = await num_outside();
  await page.getByRole("button", { name: "Its photographs" }).click();
  await page.getByRole("button", { name: "Crop, mask, scale" }).click();
  await until(page, () => window.patinate?.view === "prepare" && window.patinate.is_ready());
  assert.deepEqual([await num_outside(), await page.evaluate(() => window.patinate.is_changed())], [outside, true]);
  page.once("dialog", (question) => void question.accept());
  await page.reload();
  await until(page, () => window.patinate?.view === "prepare" && window.patinate.is_ready());
});

test("a project that was changed meanwhile is not overwritten, and the page says so", async () => {
  const text = await readFile(join(served, "paint/capture.json"), "utf8"), other = text.replace('"name": "paint"', '"name": "other"');
  await writeFile(join(served, "paint/capture.json"), other);
  await drag([20, 20], [60, 60]);
  await page.keyboard.press("Control+s");
  await page.waitForSelector(".notice.error");
  assert.match(await page.locator(".notice.error").textContent(), /changed .* nothing was saved/);
  assert.equal(await readFile(join(served, "paint/capture.json"), "utf8"), other);
  await writeFile(join(served, "paint/capture.json"), text);
  page.once("dialog", (question) => void question.accept());
  await open_place(page, server, "paint");
});

test("the frames that ingest makes stand beside their photographs, with one zoom", async () => {
  await page.getByRole("button", { name: "Ingest" }).click();
  await until(page, () => document.querySelector("dialog[open] .as-command code")?.textContent.startsWith("patinate ingest paint"));
  await dialog().getByRole("button", { name: "Start" }).click();
  await until(page, () => document.querySelector('article.job.done[aria-label="Ingest: paint_history"]'));
  await page.getByRole("article", { name: "Ingest: paint_history" }).getByRole("link", { name: "Open" }).click();
  await history_is_ready(page);
  const { width, height, texel_size_mm, mask } = JSON.parse(await readFile(join(served, "paint_history/history.json"), "utf8"));
  assert.deepEqual([width, height, mask], [64, 48, "mask.png"]);
  assert.ok(Math.abs(texel_size_mm - 0.25) < 0.005);
  await page.getByRole("button", { name: "Before and after" }).click();
  await until(page, () => window.patinate?.view === "beside" && window.patinate.is_ready());
  assert.equal(await page.getByRole("combobox", { name: "Frame" }).locator("option").count(), 4);
  // A place of the photograph, and the same one in the frame, are at the same place of their panes.
  const panes = page.locator(".photo-stage");
  const same_place = async () => {
    const [a, b] = [await on_page([8 + 20, 10 + 15], 0), await on_page([20, 15], 1)], [left, right] = [await panes.nth(0).boundingBox(), await panes.nth(1).boundingBox()];
    assert.ok(Math.hypot(a.x - left.x - b.x + right.x, a.y - left.y - b.y + right.y) < 1, JSON.stringify([a, b]));
    return a;
  };
  const at = await same_place();
  await page.mouse.move(at.x, at.y);
  await page.mouse.wheel(0, -600);
  await until(page, () => window.patinate.views().every(({ zoom }) => zoom > 2));
  await same_place();
  await page.keyboard.press("ArrowRight");
  await until(page, () => window.patinate.is_ready());
  await same_place();
  await page.keyboard.press("f");
  await page.keyboard.press("ArrowRight");
  await page.setViewportSize({ width: 900, height: 500 });
  await until(page, () => window.patinate.views().every(({ zoom, x, y }) => Math.hypot(zoom - 1, x - 0.5, y - 0.5) < 1e-9));
  await page.getByRole("button", { name: "Its history" }).click();
  await history_is_ready(page);
});
