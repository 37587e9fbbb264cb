// node build_test.mjs PATINATE: from an empty folder to a scene that runs and is built further, in a real browser. Exit code 77: skipped.
import assert from "node:assert/strict";
import { mkdir, mkdtemp, readFile, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { missing, new_page, open_browser, patinate, scene_is_ready, serve, until } from "./support.mjs";

const program = process.argv[2];
const why = missing();
if (why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const folder = await mkdtemp(join(tmpdir(), "patinate-build-"));
const served = join(folder, "served");
let server, browser, context, page;

before(async () => {
  await mkdir(served);
  await patinate(program, folder, "synth", "ledge", "-o", "made", "--cells", "8");
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

const in_page = (f, argument) => page.evaluate(f, argument);
const iteration = () => in_page(() => window.patinate.status()?.iteration ?? 0);
const labels = () => in_page(() => (window.patinate.scene().steps?.done ?? []).map((step) => step.label));
const scene = () => in_page(() => window.patinate.scene());
const dialog = () => page.locator("dialog[open]");
const open_section = async (title) => {
  const summary = page.locator(".section > summary", { hasText: new RegExp(`^${title}$`) });
  if (!(await summary.evaluate((element) => element.parentElement.open))) await summary.click();
};
/// Until the last step is called so, and the scene that it made is on screen.
const step_is = async (label) => {
  await until(page, (wanted) => window.patinate.scene()?.steps?.done.at(-1)?.label === wanted, label);
  await until(page, () => !document.querySelector("dialog[open], .progress"));
};

test("an empty folder asks for a mesh, in the page", async () => {
  await page.waitForSelector(".nothing");
  assert.match(await page.locator(".nothing h1").innerText(), /Begin with a mesh/);
  assert.equal(await page.locator(".nothing > details[open]").count(), 0, "commands of the terminal are folded away");
  const choosing = page.waitForEvent("filechooser");
  await page.getByRole("button", { name: "Choose a mesh" }).click();
  await (await choosing).setFiles({ name: "notes.txt", mimeType: "text/plain", buffer: Buffer.from("no mesh") });
  await until(page, () => document.querySelector(".notice.error")?.textContent.includes("Choose a mesh"));
  assert.deepEqual(await readdir(served), []);
});

test("a mesh is chosen, aged and runs at once, without a terminal", async () => {
  const choosing = page.waitForEvent("filechooser");
  await page.getByRole("button", { name: "Choose a mesh" }).click();
  await (await choosing).setFiles({ name: "Old wall (north).obj", mimeType: "model/obj", buffer: await readFile(join(folder, "made/mesh.obj")) });
  await dialog().waitFor();
  assert.match(await dialog().locator("h2").innerText(), /Age this/);
  assert.match(await dialog().innerText(), /It is then .* x .* x /);
  await dialog().getByText("Rust that bleeds").click();
  await dialog().getByLabel("Detail").selectOption("256");
  await dialog().getByRole("button", { name: "Age this" }).click();
  await scene_is_ready(page);
  await until(page, () => window.patinate.status()?.running && window.patinate.status().iteration >= 3);
  assert.deepEqual((await readdir(served)).filter((name) => !name.startsWith(".")).sort(), ["Old_wall_north.obj", "Old_wall_north_rust.json"]);
  await page.keyboard.press("Space");
  await until(page, () => window.patinate.status().running === false);
});

test("a dropped mesh comes beside the first one, and replaces nothing", async () => {
  const before_drop = await readFile(join(served, "Old_wall_north.obj"), "utf8");
  await page.goto(`${server.base}/#/`);
  await page.waitForSelector(".card");
  const text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  const data = await page.evaluateHandle((obj) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([obj], "Old_wall_north.obj"));
    return transfer;
  }, text);
  await page.dispatchEvent(".places", "dragover", { dataTransfer: data });
  await page.dispatchEvent(".places", "drop", { dataTransfer: data });
  await dialog().waitFor();
  assert.equal(await dialog().getByLabel("The file is in").inputValue(), "m", "a small mesh is in meters");
  await page.keyboard.press("Escape");
  assert.equal(await readFile(join(served, "Old_wall_north.obj"), "utf8"), before_drop);
  assert.equal(await readFile(join(served, "Old_wall_north-2.obj"), "utf8"), text);
});

test("a rule is checked while it is typed, and the message stands at its field", async () => {
  await page.goto(`${server.base}/#/Old_wall_north_rust.json`);
  await scene_is_ready(page);
  await open_section("Rules of aging");
  await page.getByRole("button", { name: "Add a rule" }).click();
  await dialog().waitFor();
  await dialog().getByLabel("Name", { exact: true }).fill("washing");
  const formula = dialog().getByLabel("Formula");
  await formula.fill("wate");
  const field = dialog().locator(".field", { has: page.getByLabel("Formula") });
  await until(page, () => document.querySelector("dialog .field textarea.wrong"));
  assert.match(await field.locator(".problem").innerText(), /did you mean `water`/);
  assert.ok(await dialog().getByRole("button", { name: "Add" }).isDisabled());
  await formula.fill("water * stain");
  await until(page, () => !document.querySelector("dialog .wrong"));
  await dialog().getByRole("button", { name: "Add" }).click();
  await step_is("Add washing");
  assert.deepEqual((await scene()).rules.map((rule) => rule.name), ["rust", "bleeding", "evaporation", "washing"]);
  // A formula in the panel, too.
  const panel = page.locator(".rule", { hasText: "washing" });
  await panel.locator("summary").click();
  await panel.locator(".formula").fill("water * nothing");
  await until(page, () => [...document.querySelectorAll(".rule .problem")].some((e) => e.textContent.includes("unknown")));
  await page.keyboard.press("Escape");
});

test("edits are steps: undo brings the iterations back, too", async () => {
  await page.keyboard.press("Escape");
  await in_page(() => window.patinate.send("step", { iterations: 4 }));
  await until(page, () => window.patinate.status().iteration === 4 && !window.patinate.status().running);
  await open_section("Rules of aging");
  await page.locator(".rule", { hasText: "washing" }).getByRole("button", { name: "Delete" }).click();
  await step_is("Delete washing");
  await until(page, () => window.patinate.status().iteration === 0);
  await page.locator("canvas").first().focus();
  await page.keyboard.press("Control+z");
  await until(page, () => window.patinate.scene().rules.length === 4 && window.patinate.status().iteration === 4);
  await page.keyboard.press("Control+Shift+z");
  await until(page, () => window.patinate.scene().rules.length === 3 && window.patinate.status().iteration === 0);
});

test("objects are copied, named, hidden and deleted", async () => {
  const thing = (name) => page.locator(".thing > button", { has: page.locator("b", { hasText: new RegExp(`^${name}$`) }) });
  await thing("Old_wall_north").click();
  await page.getByRole("group", { name: "Old_wall_north" }).getByRole("button", { name: "Duplicate" }).click();
  await step_is("Duplicate Old_wall_north");
  assert.deepEqual((await scene()).objects.map((o) => o.name), ["Old_wall_north", "Old_wall_north 2"]);
  await thing("Old_wall_north 2").click();
  const actions = (name) => page.getByRole("group", { name, exact: true });
  await actions("Old_wall_north 2").getByRole("button", { name: "Edit" }).click();
  await dialog().getByLabel("Name", { exact: true }).fill("far");
  await dialog().getByLabel("Position x").fill("1200");
  await dialog().getByLabel("Mesh", { exact: true }).selectOption("Old_wall_north-2.obj");
  await dialog().getByLabel("Scale").fill("300");
  await dialog().getByRole("button", { name: "Apply" }).click();
  await step_is("Old_wall_north 2 becomes far");
  const far = (await scene()).objects[1];
  assert.deepEqual([far.name, far.translate[0], far.scale], ["far", 1200, 300]);
  await thing("far").click();
  await actions("far").getByRole("button", { name: "Hide" }).click();
  const is_visible = () => in_page(() => {
    let visible = true;
    window.patinate.viewer.content.traverse((node) => { if ((node.userData.name ?? node.name) === "far" && !node.visible) visible = false; });
    return visible;
  });
  assert.equal(await is_visible(), false);
  await actions("far").getByRole("button", { name: "Show" }).click();
  assert.equal(await is_visible(), true);
  await actions("far").getByRole("button", { name: "Delete" }).click();
  await step_is("Delete far");
  assert.equal((await scene()).objects.length, 1);
});

test("emitters and materials are added; a material's new name goes into its rules", async () => {
  await page.getByRole("button", { name: "Add an emitter" }).click();
  await dialog().getByLabel("Name", { exact: true }).fill("spray");
  await dialog().getByLabel("Shape").selectOption("disk");
  await dialog().getByLabel("Diameter").fill("");
  await until(page, () => document.querySelector("dialog .wrong"));
  await dialog().getByLabel("Diameter").fill("150");
  await until(page, () => !document.querySelector("dialog .wrong"));
  await dialog().getByRole("button", { name: "Add" }).click();
  await step_is("Add spray");
  assert.deepEqual((await scene()).emitters.find((e) => e.name === "spray").size.slice(0, 1), [150]);
  await open_section("Appearance of materials");
  await page.getByRole("button", { name: "Add a material" }).click();
  await dialog().getByLabel("Name", { exact: true }).fill("lichen");
  await dialog().getByRole("button", { name: "Add" }).click();
  await step_is("Add lichen");
  await page.locator(".material", { hasText: "stain" }).locator("summary").click();
  await page.getByRole("group", { name: "stain" }).getByRole("button", { name: "Edit" }).click();
  await dialog().getByLabel("Name", { exact: true }).fill("bleed");
  await dialog().getByRole("button", { name: "Apply" }).click();
  await step_is("stain becomes bleed");
  const now = await scene();
  assert.deepEqual(now.materials, ["water", "metal", "rust", "bleed", "lichen"]);
  assert.match(now.rules.find((rule) => rule.name === "bleeding").driver, /bleed/);
  assert.doesNotMatch(now.rules.find((rule) => rule.name === "bleeding").driver, /stain/);
});

test("weather comes with the text of the scene, and is changed in its form", async () => {
  await open_section("Scene file");
  await page.getByRole("button", { name: "Edit as text" }).click();
  const text = dialog().locator("textarea");
  const document = JSON.parse(await text.inputValue());
  await text.fill("{");
  await until(page, () => document.querySelector("dialog .dialog-body > .problem")?.textContent !== "");
  document.weather = { rows: [{ time: 0, rain: 1, temperature: 10 }, { time: "6 month", rain: 0 }], repeat: "1 a" };
  await text.fill(JSON.stringify(document));
  await until(page, () => document.querySelector("dialog .dialog-body > .problem")?.textContent === "");
  await dialog().getByRole("button", { name: "Apply" }).click();
  await step_is("Scene file");
  await page.getByRole("button", { name: "Weather" }).click();
  await dialog().getByLabel("Humidity, %").first().fill("damp");
  await until(page, () => [...document.querySelectorAll("dialog .field .problem")].some((e) => e.textContent !== ""));
  await dialog().getByLabel("Humidity, %").first().fill("80");
  await until(page, () => ![...document.querySelectorAll("dialog .problem")].some((e) => e.textContent !== ""));
  await dialog().getByRole("button", { name: "Apply" }).click();
  await step_is("Weather");
});

test("what was built is a scene file that a person can read, and a command makes the same bytes", async () => {
  await in_page(() => window.patinate.send("step", { iterations: 6 }));
  await until(page, () => window.patinate.status().iteration === 6 && !window.patinate.status().running);
  await page.getByRole("button", { name: "Save the scene" }).click();
  await dialog().getByLabel(/Scene file/).fill("built.json");
  await dialog().getByRole("button", { name: "Save" }).click();
  await until(page, () => document.querySelector("dialog[open] h2")?.textContent === "The scene is saved");
  const command = await dialog().locator("code").last().innerText();
  assert.equal(command, "patinate simulate built.json -o built");
  await page.keyboard.press("Escape");
  const saved = JSON.parse(await readFile(join(served, "built.json"), "utf8"));
  assert.deepEqual(saved.materials, ["water", "metal", "rust", "bleed", "lichen"]);
  assert.equal(saved.run.iterations, 6);
  await in_page(() => window.patinate.send("export", { path: "look", what: ["textures"] }));
  await until(page, () => document.querySelector("dialog[open] h2")?.textContent === "Exported");
  await page.keyboard.press("Escape");
  await patinate(program, served, ...command.split(" ").slice(1));
  assert.deepEqual(await readFile(join(served, "built/color.png")), await readFile(join(served, "look/color.png")));
});

test("all of it is undone, step by step, to the scene of the file", async () => {
  assert.deepEqual(await labels(), ["Add washing", "Delete washing", "Duplicate Old_wall_north", "Old_wall_north 2 becomes far", "Delete far", "Add spray", "Add lichen", "stain becomes bleed", "Scene file", "Weather"]);
  await page.getByRole("button", { name: "Before all these" }).click();
  await until(page, () => window.patinate.scene().steps.done.length === 0 && window.patinate.scene().rules.length === 3);
  const now = await scene();
  assert.deepEqual([now.materials, now.objects.map((o) => o.name), now.edited], [["water", "metal", "rust", "stain"], ["Old_wall_north"], false]);
  assert.match(await page.locator(".command").innerText(), /^patinate simulate Old_wall_north_rust.json -o Old_wall_north_rust$/);
});
