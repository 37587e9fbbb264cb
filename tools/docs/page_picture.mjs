// node page_picture.mjs PAGE.html OUT.png TIME: a picture of a page that `patinate studio --save` wrote, opened as a file.
import { pathToFileURL } from "node:url";
import { history_is_ready, missing, new_page, open_browser, until } from "../../tests/studio/support.mjs";

const [, , file, out, time] = process.argv;
const why = missing();
if (why) throw new Error(why);
const { browser, context } = await open_browser({ context: { viewport: { width: 1200, height: 720 }, colorScheme: "light" } });
const page = await new_page(context);
await page.goto(pathToFileURL(file).href);
await history_is_ready(page);
await page.locator(".time input").first().evaluate((input, value) => {
  input.value = value;
  input.dispatchEvent(new Event("input", { bubbles: true }));
}, time);
await page.evaluate(() => window.patinate.settled());
await until(page, () => window.patinate.viewer.is_at_rest);
await page.screenshot({ path: out });
await browser.close();
