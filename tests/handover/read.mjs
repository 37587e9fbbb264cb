// read.mjs FILE...: what readers of others make of each .usda, .usdz or .mtlx, as one line of JSON: tinyusdz and three.js for USD, MaterialX itself for MaterialX.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

const modules = path.join(path.dirname(fileURLToPath(import.meta.url)), "node_modules");

async function usdReader() {
  // It is made for browsers and looks for one; what is made later would do the same.
  Object.assign(globalThis, { window: globalThis, document: { currentScript: null } });
  process.type = "renderer";
  const tinyusdz = (await import(path.join(modules, "tinyusdz/tinyusdz.js"))).default;
  return tinyusdz({ wasmBinary: readFileSync(path.join(modules, "tinyusdz/tinyusdz.wasm")), print: () => {}, printErr: () => {} });
}

async function readUsd(reader, file) {
  const usd = new reader.TinyUSDZLoaderNative();
  usd.setLoadTextureInNative(file.endsWith(".usdz")); // Files beside a .usda are not what it is given.
  if (!usd.loadFromBinary(new Uint8Array(readFileSync(file)), path.basename(file))) return { error: usd.error() };
  const meshes = [];
  for (let i = 0; i < usd.numMeshes(); ++i) {
    const mesh = usd.getMesh(i);
    const material = usd.getMaterial(mesh.materialId);
    const images = {};
    for (const [name, id] of Object.entries(material)) {
      if (!name.endsWith("TextureId") || id < 0) continue;
      const image = usd.getImage(usd.getTexture(id).textureImageId);
      images[name.slice(0, -9)] = { uri: image.uri, width: image.width, height: image.height };
    }
    meshes.push({ path: mesh.absPath, points: mesh.points.length / 3, corners: mesh.faceVertexIndices.length, uvs: mesh.texcoords.length / 2, images });
  }
  return file.endsWith(".usda") ? { meshes, three: await texturesOfThree(file) } : { meshes };
}

/** What three.js's reader takes for the file of each texture. */
async function texturesOfThree(file) {
  const { USDAParser } = await import(path.join(modules, "three/examples/jsm/loaders/usd/USDAParser.js"));
  const { specsByPath } = new USDAParser().parseData(readFileSync(file, "utf8"));
  return Object.entries(specsByPath)
    .filter(([name]) => name.endsWith(".inputs:file"))
    .map(([, spec]) => spec.fields.default ?? spec.fields.timeSamples.values[0]);
}

async function materialxReader() {
  const bin = path.join(modules, "@needle-tools/materialx/bin");
  // The module is made for bundlers: in node it wants `require`.
  const source = readFileSync(path.join(bin, "JsMaterialXGenShader.js"), "utf8").replace(/export default MaterialX;?\s*$/, "return MaterialX;");
  const make = new Function("require", "__filename", "__dirname", source)(createRequire(import.meta.url), path.join(bin, "JsMaterialXGenShader.js"), bin);
  const data = readFileSync(path.join(bin, "JsMaterialXGenShader.data.txt"));
  const reader = await make({
    wasmBinary: readFileSync(path.join(bin, "JsMaterialXGenShader.wasm")),
    getPreloadedPackage: () => data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength),
  });
  const generator = reader.EsslShaderGenerator.create();
  const context = new reader.GenContext(generator);
  return { reader, generator, context, library: reader.loadStandardLibraries(context) };
}

async function readMaterialx({ reader, generator, context, library }, file) {
  const document = reader.createDocument();
  document.setDataLibrary(library);
  await reader.readFromXmlString(document, readFileSync(file, "utf8"), "");
  const materials = document.getMaterialNodes().map((node) => node.getName());
  const out = { version: reader.getVersionString(), valid: document.validate(), materials, shader: 0 };
  try {
    // Every input, image and connection has to be understood for this.
    out.shader = generator.generate("first", reader.findRenderableElement(document), context).getSourceCode("pixel").length;
  } catch (problem) {
    out.error = String(problem);
  }
  return out;
}

const files = process.argv.slice(2);
const materialx = files.some((file) => file.endsWith(".mtlx")) ? await materialxReader() : null;
const usd = files.some((file) => /\.usd[az]$/.test(file)) ? await usdReader() : null;
for (const file of files) {
  let found;
  try {
    found = file.endsWith(".mtlx") ? await readMaterialx(materialx, file) : await readUsd(usd, file);
  } catch (problem) {
    found = { error: String(problem) };
  }
  console.log(JSON.stringify(found));
}
