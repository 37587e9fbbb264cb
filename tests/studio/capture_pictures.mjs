// node capture_pictures.mjs PATINATE FOLDER OUT: pictures of the way from photographs to an aged mesh, for the documentation. FOLDER has `crackle` and `urn` (tools/studio_pictures makes it).
import { cp, mkdir, readdir, readFile, rm } from "node:fs/promises";
import { join } from "node:path";
import { missing, new_page, open_browser, open_place, serve, until } from "./support.mjs";

const [, , program, folder, out] = process.argv;
const why = missing();
if (why) throw new Error(why);

const served = join(folder, "jobs"), kQuality = 82;
await rm(served, { recursive: true, force: true });
await mkdir(join(served, "urn"), { recursive: true });
await cp(join(folder, "urn/mesh.obj"), join(served, "urn/mesh.obj"));
const server = await serve(program, served);
const { browser, context } = await open_browser();
const page = await new_page(context);
const dialog = page.locator("dialog[open]");
const save = async (name) => {
  await new Promise((resolve) => setTimeout(resolve, 700));
  await page.screenshot({ path: join(out, `${name}.jpg`), type: "jpeg", quality: kQuality });
};
const form_is_ready = () => until(page, () => document.querySelector("dialog[open] .as-command code")?.textContent.startsWith("patinate "));
const start = () => dialog.getByRole("button", { name: "Start" }).click();
const at = (x, y) => page.evaluate(([a, b]) => window.patinate.on_page(a, b), [x, y]);

await page.goto(server.address);
await page.waitForSelector(".card");
await page.locator(".places-head .folder").evaluate((text) => { text.textContent = text.textContent.split("/").pop(); });
await page.getByRole("button", { name: "Begin with photographs" }).click();
const files = (await readdir(join(folder, "crackle/frames"))).sort();
const choosing = page.waitForEvent("filechooser");
await dialog.getByRole("button", { name: "Choose photographs" }).click();
await (await choosing).setFiles(await Promise.all(files.map(async (name) => ({ name: `paint_${name}`, mimeType: "image/png", buffer: await readFile(join(folder, "crackle/frames", name)) }))));
await dialog.getByLabel("Name of the new folder").fill("paint");
await save("photographs");
await dialog.getByRole("button", { name: "Copy and look at them" }).click();
await page.waitForSelector(".capture .draft");

await page.keyboard.press("t");
await open_place(page, server, "paint", "prepare");
await until(page, () => window.patinate?.view === "prepare" && window.patinate.is_ready());
await page.getByRole("combobox", { name: "Photograph" }).selectOption({ index: files.length - 1 });
await until(page, () => window.patinate.is_ready());
const size = await page.evaluate(() => document.querySelector(".layer svg").getAttribute("viewBox").split(" ").slice(2).map(Number));
const drag = async (...way) => {
  for (const [i, [x, y]] of way.entries()) {
    const place = await at(x * size[0], y * size[1]);
    await page.mouse.move(place.x, place.y, { steps: 12 });
    if (i === 0) await page.mouse.down();
  }
  await page.mouse.up();
};
await drag([0.1, 0.12], [0.9, 0.88]);
await page.getByRole("radio", { name: "Mask", exact: true }).click();
await drag([0.12, 0.85], [0.3, 0.74], [0.42, 0.86], [0.2, 0.88]);
await drag([0.78, 0.2], [0.9, 0.12]);
await page.getByRole("button", { name: "Save", exact: true }).click();
await until(page, () => !window.patinate.is_changed());
await page.locator(".notice button").first().click();
await save("mask");

await open_place(page, server, "paint");
await page.getByRole("button", { name: "Ingest" }).click();
await form_is_ready();
await start();
await until(page, () => document.querySelector('article.job.done[aria-label="Ingest: paint_history"]'), undefined, 240000);
await page.keyboard.press("t");
await open_place(page, server, "paint_history", "beside");
await until(page, () => window.patinate?.view === "beside" && window.patinate.is_ready());
const middle = await page.locator(".photo-stage").first().boundingBox();
await page.getByRole("combobox", { name: "Frame" }).selectOption({ index: files.length - 1 });
await page.mouse.move(middle.x + middle.width / 2, middle.y + middle.height / 2);
await page.mouse.wheel(0, -160);
await until(page, () => window.patinate.is_ready());
await save("beside");

await open_place(page, server, "urn/mesh.obj");
await until(page, () => window.patinate.is_ready?.());
await page.getByRole("button", { name: "New transfer" }).click();
await form_is_ready();
await dialog.getByLabel("Resolution", { exact: true }).fill("1e9");
await until(page, () => document.querySelector("dialog[open] input.wrong"));
await save("job_form");
await dialog.getByLabel("Resolution", { exact: true }).fill("2048");
await form_is_ready();
await start();
await until(page, () => document.querySelector("article.job.running progress")?.value > 0.05, undefined, 240000);
await save("jobs");
await page.getByRole("article").first().getByRole("button", { name: "Cancel" }).click();
await browser.close();
await server.close();
