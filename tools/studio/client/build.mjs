// node build.mjs FOLDER [--debug]: bundles src/main.ts with three.js into FOLDER/studio.js and studio.css, copies index.html, and writes
// studio.d, from which the build knows when to do this again.
import { build } from "esbuild";
import { copyFile, mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2] ?? "built");
const debug = process.argv.includes("--debug");
await mkdir(folder, { recursive: true });

// What is inside, with the texts that it comes under.
const licenses = await Promise.all(["three", "three-mesh-bvh"].map(async (name) => `${name}:\n${(await readFile(join(here, "node_modules", name, "LICENSE"), "utf8")).trim()}`));
const { metafile } = await build({
  absWorkingDir: here,
  entryPoints: { studio: "src/main.ts" },
  outdir: folder,
  bundle: true,
  minify: !debug,
  sourcemap: debug ? "inline" : false,
  format: "iife",
  target: ["es2021", "chrome100", "firefox100", "safari15"],
  legalComments: "none",
  banner: { js: `/*! patinate studio. Contains\n${licenses.join("\n\n")}\n*/` },
  metafile: true,
  logLevel: "warning",
});
await copyFile(join(here, "index.html"), join(folder, "index.html"));

const inputs = [...Object.keys(metafile.inputs), "index.html"].map((path) => resolve(here, path).replaceAll(" ", "\\ "));
await writeFile(join(folder, "studio.d"), `${join(folder, "studio.js").replaceAll(" ", "\\ ")}: ${inputs.join(" \\\n  ")}\n`);
