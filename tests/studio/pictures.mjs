// node pictures.mjs PATINATE FOLDER OUT: a picture of every view, for the documentation (tools/studio_pictures makes FOLDER).
import { join } from "node:path";
import { history_is_ready, missing, new_page, open_browser, open_place, scene_is_ready, serve, until, write_sky } from "./support.mjs";

const [, , program, folder, out] = process.argv;
const why = missing();
if (why) throw new Error(why);

const kQuality = 82;
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const server = await serve(program, folder);
const { browser, context } = await open_browser();
const page = await new_page(context);
await page.goto(server.address);

async function save(name) {
  await sleep(700);
  await until(page, () => !window.patinate.viewer || window.patinate.viewer.is_at_rest);
  await page.screenshot({ path: join(out, `${name}.jpg`), type: "jpeg", quality: kQuality });
}
async function look(theme, width = 1280, height = 720) {
  await page.setViewportSize({ width, height });
  if ((await page.evaluate(() => document.documentElement.dataset.theme)) !== theme) await page.keyboard.press("t");
}
async function set_time(share, which = 0) {
  await page.locator(".time input").nth(which).evaluate((input, s) => {
    input.value = String(Number(input.min) + s * (Number(input.max) - Number(input.min)));
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }, share);
  await page.evaluate(() => window.patinate.settled());
}

await look("dark");
await until(page, () => document.querySelectorAll(".card img").length >= 2);
// The manual shows no folder of the machine on which its pictures are taken.
await page.locator(".places-head .folder").evaluate((text) => { text.textContent = text.textContent.split("/").pop(); });
await save("places");

await open_place(page, server, "urn/mesh.obj", "age");
await until(page, () => document.querySelector("dialog[open]") && window.patinate.is_ready());
await page.locator("dialog[open]").getByText("Patina on copper").click();
await save("age");

await page.keyboard.press("Escape");
await look("light");
await open_place(page, server, "urn/rain.json");
await scene_is_ready(page);
await page.locator("summary", { hasText: "Rules of aging" }).click();
await page.getByRole("button", { name: "Add a rule" }).click();
await page.locator("dialog[open]").getByLabel("Formula").fill("wate * patina");
await until(page, () => document.querySelector("dialog .wrong"));
await save("build");

await look("light");
await open_place(page, server, "paint");
await history_is_ready(page);
await page.keyboard.press("2");
await set_time(0.2);
await save("history_wipe");

await look("dark");
await open_place(page, server, "painted_urn");
await history_is_ready(page);
await set_time(0.85);
await page.mouse.click(470, 330);
await until(page, () => document.querySelector(".source img")?.naturalWidth > 0);
await save("transfer");

await look("light");
await open_place(page, server, "rained_urn");
await history_is_ready(page);
await set_time(0.5);
await page.keyboard.press("3");
await save("difference");

await look("light");
await open_place(page, server, "mold");
await until(page, () => document.querySelector(".pictures img")?.naturalWidth > 0);
await save("capture");

await look("dark");
await open_place(page, server, "registered");
await until(page, () => Object.keys(window.patinate?.scans?.() ?? {}).length > 0 && document.querySelector(".pictures img")?.naturalWidth > 0);
await save("registration");

await open_place(page, server, "copper_mold");
await history_is_ready(page);
await set_time(0);
await page.locator("summary", { hasText: /^Light$/ }).click();
await page.evaluate(() => window.patinate.light_relief(true));
await save("relief");

await look("dark");
await open_place(page, server, "urn/rain.json");
await scene_is_ready(page);
const run_until = async (iteration) => {
  await page.evaluate(() => window.patinate.send("run"));
  await until(page, (end) => window.patinate.status().iteration >= end, iteration, 240000);
  await page.evaluate(() => window.patinate.send("pause"));
};
await run_until(250);
await page.locator(".thing button", { hasText: "spout" }).click();
await save("simulation");

await page.keyboard.press("Escape");
await page.keyboard.press("p");
await page.mouse.move(455, 330);
await page.mouse.down();
for (let i = 0; i < 30; ++i) {
  await page.mouse.move(455 + 3 * i, 330 + 20 * Math.sin(i / 4));
  await sleep(100);
}
await page.mouse.up();
await page.mouse.move(500, 300);
await look("light", 820, 1180);
await page.locator("select", { hasText: "nothing" }).selectOption("water");
await sleep(1500);
await save("painting_tablet");

await look("light", 1280, 720);
await open_place(page, server, "rained_urn", "live");
await scene_is_ready(page);
await write_sky(join(folder, "sky.hdr"));
await page.locator("summary", { hasText: /^Light$/ }).click();
await page.getByLabel("A picture of surroundings").setInputFiles(join(folder, "sky.hdr"));
await until(page, () => [...document.querySelectorAll("select")].some((s) => s.value === "sky.hdr"));
await page.getByText("Show emitters").click();
await page.locator(".notice button[title=Close], .notices button").first().click().catch(() => {});
await page.locator("summary", { hasText: /^Picture$/ }).click();
await page.locator("summary", { hasText: /^Picture$/ }).scrollIntoViewIfNeeded();
await save("look");

await look("dark", 1280, 720);
await open_place(page, server, "rained_urn", "live");
await scene_is_ready(page);
for (const title of ["Emitters and objects", "Paint on the surface", "How it flows", "Rules of aging"]) await page.locator("summary", { hasText: title }).click();
await page.locator("summary", { hasText: "Formula and amounts" }).first().click();
await save("finished");

await browser.close();
await server.close();
