// node paint_test.mjs PATINATE: the control of a transfer is painted with real input events, in a real browser. Exit code 77: skipped.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { promisify } from "node:util";
import { history_is_ready, missing, new_page, open_browser, open_place, patinate, serve, until } from "./support.mjs";

const program = process.argv[2];
const why = missing();
if (why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const folder = await mkdtemp(join(tmpdir(), "patinate-paint-"));
let server, browser, context, page;

before(async () => {
  await patinate(program, folder, "synth", "crackle", "--width", "96", "--height", "96", "--num-frames", "3", "-o", "capture");
  await patinate(program, folder, "ingest", "capture", "-o", "history");
  await patinate(program, folder, "synth", "sculpture", "--resolution", "32", "-o", "urn");
  await patinate(program, folder, "transfer", "history", "urn/mesh.obj", "--control", "thickness=facing", "--resolution", "128", "-o", "aged");
  server = await serve(program, folder);
  ({ browser, context } = await open_browser());
  page = await new_page(context);
  await page.goto(server.address);
  await open_place(page, server, "aged");
  await history_is_ready(page);
});

after(async () => {
  assert.deepEqual(page?.problems ?? [], []);
  await browser?.close();
  await server?.close();
  await rm(folder, { recursive: true, force: true });
});

const hash = () => page.evaluate(() => window.patinate.texture_hash());
const steps = () => page.locator(".steps-done li.done").allInnerTexts();
const settled = () => page.evaluate(() => window.patinate.paint().settled());
/// A place in the window that shows the surface, and is not the camera's.
const middle = async () => {
  const box = await page.locator("canvas").boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
};
let unpainted, painted;

test("the panel asks nothing of the server before it is used, and then says what can be painted", async () => {
  await page.locator("summary", { hasText: /^Paint the control$/ }).click();
  await page.getByRole("switch", { name: "Paint" }).click();
  await until(page, () => document.querySelector("canvas.painting"));
  const panel = page.locator(".section", { hasText: "Paint the control" });
  for (const label of ["Value", "Flow", "Radius"]) await panel.getByRole("slider", { name: label, exact: true }).waitFor();
  assert.match(await panel.innerText(), /0 is the least thickness of the history \(.*\), 1 the greatest/);
  assert.ok(await panel.getByRole("button", { name: "Undo" }).isDisabled());
  unpainted = await hash();
});

test("a stroke changes the texture where it was, and the camera stays", async () => {
  const value = page.getByRole("textbox", { name: "Value", exact: true });
  await value.fill("0.1");
  await value.press("Enter");
  const camera = await page.evaluate(() => window.patinate.viewer.camera.position.toArray());
  const { x, y } = await middle();
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 6; ++i) await page.mouse.move(x + 8 * i, y + 3 * i);
  await page.mouse.up();
  await until(page, () => window.patinate.paint().num_answers >= 2);
  await settled();
  painted = await hash();
  assert.notEqual(painted, unpainted);
  assert.deepEqual(await page.evaluate(() => window.patinate.viewer.camera.position.toArray()), camera);
  assert.deepEqual((await steps())[0], "Paint thickness 0.1");
});

test("borders are refined when the brush rests", async () => {
  await until(page, () => [...document.querySelectorAll(".steps-done li.done")].at(-1)?.textContent === "Refine borders");
  await settled();
  assert.equal((await steps()).length, 2, "a stroke is one step, however many requests it takes");
  painted = await hash();
});

test("Ctrl Z takes steps back to the texel, and Ctrl Shift Z does them again", async () => {
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  await until(page, () => document.querySelectorAll(".steps-done li.undone").length === 2);
  await settled();
  assert.equal(await hash(), unpainted);
  await page.keyboard.press("Control+Shift+z");
  await page.keyboard.press("Control+Shift+z");
  await until(page, () => document.querySelectorAll(".steps-done li.done").length === 2);
  await settled();
  assert.equal(await hash(), painted);
});

test("another time shows what was painted, too", async () => {
  const times = await page.evaluate(async () => {
    window.patinate.set_time(5);
    await window.patinate.settled();
    await window.patinate.paint().settled();
    const other = window.patinate.texture_hash();
    window.patinate.set_time(0);
    await window.patinate.settled();
    await window.patinate.paint().settled();
    return { other, back: window.patinate.texture_hash() };
  });
  assert.notEqual(times.other, painted);
  assert.equal(times.back, painted);
});

test("the command that the page shows makes the same texture", async () => {
  const command = await page.locator(".section code.command").innerText();
  assert.match(command, /^patinate transfer history urn\/mesh.obj .* --edits aged.edits.json -o OUT$/);
  await promisify(execFile)("/bin/sh", ["-c", `${command.replace(/^patinate/, `'${program}'`)} --quiet`], { cwd: folder });
  const edits = JSON.parse(await readFile(join(folder, "aged.edits.json"), "utf8")).edits;
  assert.deepEqual(JSON.parse(await readFile(join(folder, "OUT/edits.json"), "utf8")).edits, edits);
  const response = await server.get("/api/texture?place=OUT&time=0");
  assert.equal(response.headers.get("X-Hash"), painted);
});
