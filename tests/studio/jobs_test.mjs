// node jobs_test.mjs PATINATE: commands started in the page with real input events, in a real browser: from photographs to a history, from a mesh to an aged one. Exit code 77: skipped.
import assert from "node:assert/strict";
import { cp, mkdir, mkdtemp, readdir, rm, stat } from "node:fs/promises";
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

const folder = await mkdtemp(join(tmpdir(), "patinate-jobs-"));
const served = join(folder, "served");
let server, browser, context, page;

before(async () => {
  await patinate(program, folder, "synth", "crackle", "--width", "96", "--height", "96", "--num-frames", "4", "-o", "capture");
  await patinate(program, folder, "synth", "sculpture", "--resolution", "32", "-o", "made");
  await mkdir(join(served, "urn"), { recursive: true });
  await cp(join(folder, "capture/frames"), join(served, "paint"), { recursive: true });
  await cp(join(folder, "made/mesh.obj"), join(served, "urn/mesh.obj"));
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
const card = (name) => page.getByRole("article", { name });
/// The form of a command is there, and its command can be started.
const form_is_ready = async () => {
  await until(page, () => document.querySelector("dialog[open] .as-command code")?.textContent.startsWith("patinate "));
  assert.ok(await dialog().getByRole("button", { name: "Start" }).isEnabled());
};
const start = async () => {
  await dialog().getByRole("button", { name: "Start" }).click();
  await until(page, () => !document.querySelector("dialog[open]"));
};
const job_is = (name, state) => until(page, ([wanted, word]) => document.querySelector(`article.job.${word}[aria-label="${wanted}"]`), [name, state]);

test("photographs become a capture, which says what it has found", async () => {
  await page.getByRole("button", { name: "Begin with photographs" }).click();
  await dialog().getByRole("button", { name: "Use a folder that is here already" }).click();
  await dialog().getByLabel("Folder").waitFor();
  assert.equal(await dialog().getByLabel("Folder").inputValue(), "paint");
  await form_is_ready();
  assert.equal(await dialog().getByLabel("Name of the result").getAttribute("placeholder"), "paint/capture.json");
  await start();
  await job_is("Init: paint/capture.json", "done");
  const said = card("Init: paint/capture.json");
  await said.locator("details.messages > summary").click();
  assert.match(await said.locator("details.messages").innerText(), /found: .*\n(.*\n)*check: /);
  await said.getByRole("link", { name: "Open" }).click();
  await page.waitForSelector(".capture");
  await until(page, () => document.querySelectorAll(".capture .pictures img").length >= 4);
  assert.match(await page.locator(".draft").innerText(), /found\n4 photographs/);
});

test("the capture becomes a history, with each photograph beside what became of it", async () => {
  await page.getByRole("button", { name: "Ingest" }).click();
  await form_is_ready();
  await dialog().getByRole("switch", { name: "Stabilize" }).click();
  await until(page, () => document.querySelector("dialog[open] .as-command code").textContent.includes("--stabilize"));
  await dialog().getByRole("switch", { name: "Stabilize" }).click();
  await until(page, () => !document.querySelector("dialog[open] .as-command code").textContent.includes("--stabilize"));
  await start();
  await job_is("Ingest: paint_history", "done");
  await card("Ingest: paint_history").getByRole("link", { name: "Open" }).click();
  await history_is_ready(page);
  await page.getByRole("button", { name: "How it was made" }).click();
  const pictures = page.getByRole("button", { name: /^Enlarge: (the photograph|what became of it)$/ });
  await until(page, () => document.querySelectorAll(".capture .pictures img").length >= 8);
  assert.equal(await pictures.count(), 8);
  await until(page, () => [...document.querySelectorAll(".capture .pictures img")].slice(0, 2).every((img) => img.naturalWidth > 0));
  await page.getByRole("button", { name: "Its history" }).click();
  await page.getByRole("button", { name: "Its report" }).click();
  await page.waitForSelector("iframe.report-frame");
});

test("a mesh is aged with it, and what is wrong stands at its field", async () => {
  await open_place(page, server, "urn/mesh.obj");
  await page.getByRole("button", { name: "New transfer" }).click();
  await form_is_ready();
  assert.equal(await dialog().getByLabel("History", { exact: true }).inputValue(), "paint_history");
  assert.equal(await dialog().getByLabel("Mesh", { exact: true }).inputValue(), "urn/mesh.obj");
  const size = dialog().getByLabel("Resolution", { exact: true });
  await size.fill("twelve");
  await until(page, () => document.querySelector("dialog[open] input.wrong"));
  const field = dialog().locator(".field", { has: page.getByLabel("Resolution", { exact: true }) });
  assert.match(await field.locator(".problem").innerText(), /Found `twelve`; expected an integer/);
  assert.ok(await dialog().getByRole("button", { name: "Start" }).isDisabled());
  await size.fill("128");
  await form_is_ready();
  // One that is folded away is shown when it is wrong.
  await dialog().locator("details.more > summary").click();
  await dialog().getByLabel("Coherence", { exact: true }).fill("7");
  await until(page, () => document.querySelector("dialog[open] details.more input.wrong"));
  await dialog().getByLabel("Coherence", { exact: true }).fill("");
  await dialog().getByLabel("Seed", { exact: true }).fill("3");
  await form_is_ready();
  const line = await dialog().locator(".as-command code").innerText();
  assert.match(line, /^patinate transfer paint_history urn\/mesh.obj -o paint_history_urn_aged --control accessibility --resolution 128 --seed 3$/);
  await start();
  await job_is("Transfer: paint_history_urn_aged", "done");
  const made = card("Transfer: paint_history_urn_aged");
  await made.locator("details.line > summary").click();
  assert.equal(await made.locator("code").innerText(), line);
  await made.getByRole("link", { name: "Open" }).click();
  await history_is_ready(page);
  assert.ok((await stat(join(served, "paint_history_urn_aged/transfer.json"))).isFile());
});

test("its picture is rendered, shown and downloaded", async () => {
  assert.ok(await page.locator("aside.jobs").isHidden(), "it does not cover what is opened");
  await page.getByRole("button", { name: "Render" }).click();
  await form_is_ready();
  await dialog().getByLabel("Width", { exact: true }).fill("96");
  await dialog().getByLabel("Height", { exact: true }).fill("96");
  await form_is_ready();
  await start();
  await job_is("Render: paint_history_urn_aged.png", "done");
  await until(page, () => document.querySelector("article.job img")?.naturalWidth > 0);
  const coming = page.waitForEvent("download");
  await card("Render: paint_history_urn_aged.png").getByRole("link", { name: "Download" }).click();
  assert.equal((await coming).suggestedFilename(), "paint_history_urn_aged.png");
});

test("a model is opened or downloaded", async () => {
  await page.locator("aside.jobs").getByRole("button", { name: "Close" }).click();
  await page.getByRole("button", { name: "Export" }).click();
  await form_is_ready();
  await start();
  await job_is("Export: paint_history_urn_aged.glb", "done");
  const made = card("Export: paint_history_urn_aged.glb");
  assert.equal(await made.getByRole("link", { name: "Open" }).count(), 1);
  const coming = page.waitForEvent("download");
  await made.getByRole("link", { name: "Download" }).click();
  assert.equal((await coming).suggestedFilename(), "paint_history_urn_aged.glb");
});

test("a job that is canceled ends, and may be started again", async () => {
  await page.goto(`${server.base}/#/urn%2Fmesh.obj`);
  await page.getByRole("button", { name: "New transfer" }).click();
  await form_is_ready();
  await dialog().getByLabel("Resolution", { exact: true }).fill("1024");
  await dialog().getByLabel("Quality", { exact: true }).selectOption("best");
  await dialog().getByLabel("Name of the result").fill("fine");
  await form_is_ready();
  await start();
  await job_is("Transfer: fine", "running");
  await until(page, () => document.querySelector("article.job.running progress")?.value > 0);
  await card("Transfer: fine").getByRole("button", { name: "Cancel" }).click();
  await job_is("Transfer: fine", "canceled");
  assert.match(await card("Transfer: fine").innerText(), /interrupted/);
  assert.ok(!(await readdir(served)).includes("fine"));
  await card("Transfer: fine").getByRole("button", { name: "Try again" }).click();
  await form_is_ready();
  assert.equal(await dialog().getByLabel("Name of the result").inputValue(), "fine");
  assert.equal(await dialog().getByLabel("Quality", { exact: true }).inputValue(), "best");
  await page.keyboard.press("Escape");
});

test("what has ended is listed with the places, and the jobs are there after the page is loaded again", async () => {
  await page.goto(`${server.base}/#/`);
  await page.reload();
  await page.waitForSelector(".card.transfer");
  await page.getByRole("button", { name: "Jobs" }).click();
  assert.deepEqual(await page.locator("aside.jobs article").evaluateAll((all) => all.map((each) => each.getAttribute("aria-label"))),
    ["Transfer: fine", "Export: paint_history_urn_aged.glb", "Render: paint_history_urn_aged.png", "Transfer: paint_history_urn_aged", "Ingest: paint_history", "Init: paint/capture.json"]);
});
