// node browser_test.mjs FOLDER: the manual that tools/docs/build made, opened as files: no page is wider than a telephone or a laptop, none fails to load
// a file or a script, and the search finds pages without a server. Exit code 77: skipped, where there is no browser.
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { missing, open_browser, until } from "../studio/support.mjs";

const why = missing();
if (why) {
  console.log(`manual: skipped: ${why}`);
  process.exit(77);
}
const folder = process.argv[2];
const address = (page) => pathToFileURL(join(folder, page)).href;
const { browser } = await open_browser();
const problems = [];
for (const width of [390, 1280]) {
  const page = await browser.newPage({ viewport: { width, height: 900 } });
  page.on("pageerror", (error) => problems.push(`${page.url()}: ${error.message}`));
  page.on("requestfailed", (request) => problems.push(`${page.url()}: cannot load ${request.url()}`));
  for (const name of readdirSync(folder, { recursive: true }).map(String).filter((file) => file.endsWith(".html"))) {
    await page.goto(address(name));
    const over = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    if (over > 0) problems.push(`${name}: ${over} px wider than ${width}`);
  }
  await page.goto(`${address("search.html")}?q=accessibility`);
  await until(page, () => document.querySelectorAll("#search-results li a").length >= 10).catch(() => problems.push("the search for accessibility finds fewer than ten pages"));
}
await browser.close();
for (const problem of problems) console.log(problem);
console.log(`manual: ${problems.length} problems`);
process.exit(problems.length ? 1 : 0);
