// node three_test.mjs PROGRAM: what `render` draws against three.js under the same light. Both draw a sphere of one material. three.js lacks two
// things that `render` has, which are added here by a formula of their own (an integral over the hemisphere, no table of the program's): the energy
// that single scattering loses, and what the mirror leaves of the diffuse light. What is left is bounded by rounding to 8 bits and by the rays' noise.
// Exit code 77: skipped, where there is no browser.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { missing, open_browser, patinate } from "./support.mjs";

const kThree = new URL("../../tools/studio/client/node_modules/three/build/", import.meta.url);
const why = missing() || (existsSync(kThree) ? "" : "tools/studio/client/node_modules is missing (tools/setup --tests installs it)");
if (why) {
  console.log(`three: skipped: ${why}`);
  process.exit(77);
}
const program = process.argv[2];
const kSide = 96, kRays = 16, kFov_deg = 30, kDistance = 4.5, kAzimuth = 25, kElevation = 15, kLight = 0.5, kLightAzimuth = -40, kLightElevation = 35, kNear = 3.5;
const kMaterials = [
  { name: "lacquer", color: [0.5, 0.3, 0.2], metalness: 0, roughness: 0.3 },
  { name: "clay", color: [0.5, 0.3, 0.2], metalness: 0, roughness: 0.8 },
  { name: "copper", color: [0.93, 0.6, 0.47], metalness: 1, roughness: 0.35 },
  { name: "rough copper", color: [0.93, 0.6, 0.47], metalness: 1, roughness: 0.7 },
];

const radians = (degrees) => (degrees * Math.PI) / 180;
const toward = (azimuth, elevation) => [Math.cos(radians(elevation)) * Math.sin(radians(azimuth)), Math.sin(radians(elevation)), Math.cos(radians(elevation)) * Math.cos(radians(azimuth))];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((v) => v / Math.sqrt(dot(a, a)));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const along = (s, a, b) => a.map((v, i) => v + s * b[i]);
const code = (linear) => 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * Math.min(1, linear) ** (1 / 2.4) - 0.055);
const linear = (value) => (value <= 0.04045 * 255 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);

// --- GGX by its definition: what the lobe reflects of radiance 1 and of radiance l_t, l_n, split into the parts times F0 and times 1.
function integrals(roughness, cos_view) {
  const a2 = roughness ** 4, view = [Math.sqrt(1 - cos_view * cos_view), 0, cos_view], kN = 160;
  const sum = { scale: 0, bias: 0, scale_across: 0, bias_across: 0, scale_up: 0, bias_up: 0 };
  // Microfacets by their density, seen in polar steps; each reflects into a cone of 4 (v . h) times its solid angle.
  for (let i = 0; i < kN; ++i) {
    const u = (i + 0.5) / kN, cos2 = (1 - u) / (1 + (a2 - 1) * u), sin = Math.sqrt(1 - cos2);
    for (let j = 0; j < kN; ++j) {
      const phi = (2 * Math.PI * (j + 0.5)) / kN, h = [sin * Math.cos(phi), sin * Math.sin(phi), Math.sqrt(cos2)], vh = dot(view, h);
      const l = h.map((v, k) => 2 * vh * v - view[k]);
      if (!(l[2] > 0) || !(vh > 0)) continue;
      const smith = (c) => Math.sqrt(a2 + (1 - a2) * c * c);
      const share = (vh / h[2]) * ((2 * l[2]) / (l[2] * smith(cos_view) + cos_view * smith(l[2]))) / kN / kN;
      const grazing = (1 - vh) ** 5;
      for (const [name, weight] of [["", 1], ["_across", l[0]], ["_up", l[2]]]) {
        sum[`scale${name}`] += (1 - grazing) * share * weight;
        sum[`bias${name}`] += grazing * share * weight;
      }
    }
  }
  return sum;
}
const tables = new Map();
/// Between values at 65 cosines.
function lobe_integrals(roughness, cos_view) {
  if (!tables.has(roughness)) tables.set(roughness, Array.from({ length: 65 }, (_, i) => integrals(roughness, Math.max(0.02, i / 64))));
  const table = tables.get(roughness), at = Math.min(63, Math.floor(cos_view * 64)), t = cos_view * 64 - at;
  return Object.fromEntries(Object.keys(table[0]).map((key) => [key, (1 - t) * table[at][key] + t * table[at + 1][key]]));
}
/// three.js has 2^((-5.55473 x - 6.98316) x) for (1 - x)^5 in Schlick's formula: 1.4 % more of a lacquer's highlight.
function schlick_over_fit(f0, { view }, lamp) {
  const x = dot(view, unit(along(1, view, lamp))), with_term = (term) => f0 + (1 - f0) * term;
  return with_term((1 - x) ** 5) / with_term(2 ** ((-5.55473 * x - 6.98316) * x));
}
const all_reflected = (e, f0) => (1 + f0 * (1 / (e.scale + e.bias) - 1)) * (f0 * e.scale + e.bias);

// --- The scene: a sphere of radius 1 at the origin.
const kEye = toward(kAzimuth, kElevation), kLamp = toward(kAzimuth + kLightAzimuth, kLightElevation);
/// Where the rays of a pixel's middle meet the sphere; nothing near its outline.
function normal_at(x, y) {
  const right = unit(cross([0, 1, 0], kEye)), up = cross(kEye, right), t = Math.tan(radians(kFov_deg / 2));
  const direction = unit(along(((2 * (x + 0.5)) / kSide - 1) * t, along((1 - (2 * (y + 0.5)) / kSide) * t, kEye.map((v) => -v), up), right));
  const position = kEye.map((v) => kDistance * v), b = dot(position, direction), c = kDistance * kDistance - 1, root2 = b * b - c;
  if (!(root2 > 0)) return undefined;
  const n = along(-b - Math.sqrt(root2), position, direction), view = direction.map((v) => -v);
  return dot(n, view) > 0.3 ? { n, view } : undefined;
}

async function write_sphere(page, file) {
  const { position, normal, uv, index } = await page.evaluate(() => {
    const g = new THREE.SphereGeometry(1, 256, 128);
    return { position: [...g.attributes.position.array], normal: [...g.attributes.normal.array], uv: [...g.attributes.uv.array], index: [...g.index.array] };
  });
  const rows = (values, width, name) => Array.from({ length: values.length / width }, (_, i) => `${name} ${values.slice(width * i, width * i + width).join(" ")}`).join("\n");
  const corner = (i) => `${i + 1}/${i + 1}/${i + 1}`;
  const faces = Array.from({ length: index.length / 3 }, (_, i) => `f ${index.slice(3 * i, 3 * i + 3).map(corner).join(" ")}`).join("\n");
  await writeFile(file, [rows(position, 3, "v"), rows(uv, 2, "vt"), rows(normal, 3, "vn"), faces, ""].join("\n"));
}

/// Of one color, as a PNG of 4 x 4 codes; returns what it says in [0, 1].
async function write_map(page, file, codes) {
  const url = await page.evaluate((rgb) => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 4, height: 4 }), context = canvas.getContext("2d");
    context.fillStyle = `rgb(${rgb.join(",")})`;
    context.fillRect(0, 0, 4, 4);
    return canvas.toDataURL("image/png");
  }, codes);
  await writeFile(file, Buffer.from(url.split(",")[1], "base64"));
}

/// Radiance a + b . d, which turns with nothing: 64 x 32, RGBE in rows that are not compressed.
const kSky = { mean: 0.4, slope: [0.12, 0.2, -0.08] };
async function write_sky(file) {
  const width = 64, height = 32, bytes = Buffer.alloc(4 * width * height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) bytes.set(rgbe(radiance(sky_direction((x + 0.5) / width, (y + 0.5) / height))), 4 * (y * width + x));
  }
  await writeFile(file, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), bytes]));
}
/// The middle of the picture lies behind the object as the camera sees it.
function sky_direction(u, v) {
  const around = radians(kAzimuth) + Math.PI - 2 * Math.PI * (u - 0.5), up = Math.PI * (0.5 - v);
  return [Math.cos(up) * Math.sin(around), Math.sin(up), Math.cos(up) * Math.cos(around)];
}
const radiance = (d) => kSky.mean + dot(kSky.slope, d);
function rgbe(value) {
  const exponent = Math.floor(Math.log2(value)) + 1, mantissa = Math.min(255, Math.round((value / 2 ** exponent) * 256));
  return [mantissa, mantissa, mantissa, exponent + 128];
}

/// In the page: linear radiance of the sphere, each pixel the mean of its rays. @returns rows from the top, RGB.
async function draw_three(page, material, light) {
  return page.evaluate(async ({ material, light, side, rays, fov, distance, eye }) => {
    const n = Math.sqrt(rays) * side, renderer = window.renderer ??= new THREE.WebGLRenderer();
    const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(fov, 1, 0.1, 20);
    camera.position.set(...eye.map((v) => distance * v));
    camera.lookAt(0, 0, 0);
    const surface = new THREE.MeshPhysicalMaterial({ roughness: material.roughness, metalness: material.metalness, specularIntensity: material.mirror ? 1 : 0 });
    surface.color.setRGB(...material.color);
    // three.js draws what is curved within a pixel rougher; the rays of a pixel need no such thing.
    surface.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace("#include <lights_physical_fragment>", THREE.ShaderChunk.lights_physical_fragment.replace(/material\.roughness \+= geometryRoughness;/, ""));
    };
    scene.add(new THREE.Mesh(new THREE.SphereGeometry(1, 256, 128), surface));
    if (light.lamp) {
      const { near } = light, lamp = near ? new THREE.PointLight(0xffffff, Math.PI * light.strength * near * near) : new THREE.DirectionalLight(0xffffff, Math.PI * light.strength);
      lamp.position.set(...light.lamp.map((v) => (near || 10) * v));
      scene.add(lamp);
    }
    if (light.sky) {
      const data = new Float32Array(light.sky.flatMap((v) => [v, v, v, 1])), sky = new THREE.DataTexture(data, light.width, light.height, THREE.RGBAFormat, THREE.FloatType);
      sky.mapping = THREE.EquirectangularReflectionMapping;
      sky.minFilter = sky.magFilter = THREE.LinearFilter;
      sky.needsUpdate = true;
      scene.environment = new THREE.PMREMGenerator(renderer).fromEquirectangular(sky).texture;
    }
    const target = new THREE.WebGLRenderTarget(n, n, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    const all = new Float32Array(4 * n * n), out = new Array(3 * side * side).fill(0), step = n / side;
    renderer.readRenderTargetPixels(target, 0, 0, n, n, all);
    for (let y = 0; y < n; ++y) {
      for (let x = 0; x < n; ++x) {
        const at = 3 * (Math.floor((n - 1 - y) / step) * side + Math.floor(x / step));
        for (let c = 0; c < 3; ++c) out[at + c] += all[4 * (y * n + x) + c] / rays;
      }
    }
    target.dispose();
    return out;
  }, { material, light, side: kSide, rays: kRays, fov: kFov_deg, distance: kDistance, eye: kEye });
}

/// The same sky as three.js's pictures of 360 x 180 degrees have it, from the bottom.
function sky_of_three() {
  return Array.from({ length: 64 * 32 }, (_, i) => {
    const around = 2 * Math.PI * (((i % 64) + 0.5) / 64 - 0.5), up = Math.PI * ((Math.floor(i / 64) + 0.5) / 32 - 0.5);
    return radiance([Math.cos(up) * Math.cos(around), Math.sin(up), Math.cos(up) * Math.sin(around)]);
  });
}

/// Codes of a PNG, rows from the top, RGB.
async function read_png(page, file) {
  const url = `data:image/png;base64,${(await readFile(file)).toString("base64")}`;
  return page.evaluate(async (source) => {
    const image = await createImageBitmap(await (await fetch(source)).blob(), { colorSpaceConversion: "none" });
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    return [...context.getImageData(0, 0, image.width, image.height).data].filter((_, i) => i % 4 !== 3);
  }, url);
}

async function draw_ours(page, folder, material, parameters) {
  await patinate(program, folder, "render", "sphere.obj", "-o", "ours.png", "--force", "--texture", "color.png", "--roughness-map", "roughness.png", "--metalness-map", "metalness.png", "--width", kSide, "--height", kSide,
    "--samples", kRays, "--fov", kFov_deg, "--target", "0,0,0", "--distance", kDistance, "--azimuth", kAzimuth, "--elevation", kElevation, "--no-ground", "--occlusion-samples", "0", ...parameters);
  return read_png(page, join(folder, "ours.png"));
}

/// Largest and mean difference in codes over the sphere, and by how much the bound is exceeded. @param expected  (pixel, channel) -> linear.
function differences(ours, expected) {
  // Rounding to 8 bits, and half a percent: the program's table of the lobe's energy.
  const bound = (value) => 0.5 + code(1.005 * value) - code(value);
  let most = 0, excess = -Infinity, sum = 0, count = 0;
  for (let y = 0; y < kSide; ++y) {
    for (let x = 0; x < kSide; ++x) {
      const seen = normal_at(x, y);
      if (!seen) continue;
      for (let c = 0; c < 3; ++c) {
        const value = expected(3 * (y * kSide + x) + c, c, seen);
        if (value === undefined) continue;
        const off = Math.abs(code(value) - ours[3 * (y * kSide + x) + c]);
        most = Math.max(most, off);
        excess = Math.max(excess, off - bound(value));
        sum += off;
        count += 1;
      }
    }
  }
  return { most, excess, mean: sum / count };
}

const folder = await mkdtemp(join(tmpdir(), "patinate-three-"));
const { browser, context } = await open_browser();
const page = await context.newPage();
await page.route("http://three.test/**", async (route) => {
  const name = new URL(route.request().url()).pathname.slice(1);
  if (!name) return route.fulfill({ contentType: "text/html", body: `<script type="module">import * as THREE from "/three.module.js"; window.THREE = THREE;</script>` });
  return route.fulfill({ contentType: "text/javascript", path: new URL(name, kThree).pathname });
});
await page.goto("http://three.test/");
await page.waitForFunction(() => window.THREE);
try {
  await write_sphere(page, join(folder, "sphere.obj"));
  await write_sky(join(folder, "sky.hdr"));
  for (const described of kMaterials) {
    // What 8 bits make of the material.
    const codes = described.color.map((v) => Math.round(code(v))), roughness_code = Math.round(255 * described.roughness);
    await write_map(page, join(folder, "color.png"), codes);
    await write_map(page, join(folder, "roughness.png"), [roughness_code, roughness_code, roughness_code]);
    await write_map(page, join(folder, "metalness.png"), Array(3).fill(255 * described.metalness));
    const material = { ...described, color: codes.map(linear), roughness: roughness_code / 255, mirror: true };
    const m = material.metalness, f0 = (c) => (m === 1 ? material.color[c] : 0.04), energy = (seen) => lobe_integrals(material.roughness, dot(seen.n, seen.view));
    const diffuse_left = (e, c) => 1 - all_reflected(e, f0(c));

    // One lamp, far or near: rays that are parallel, and rays that are not and fall off.
    let ours;
    for (const near of [0, kNear]) {
      const lamp = { lamp: kLamp, strength: kLight, near };
      const whole = await draw_three(page, material, lamp), matt = m === 1 ? whole.map(() => 0) : await draw_three(page, { ...material, mirror: false }, lamp);
      ours = await draw_ours(page, folder, material, ["--light", kLight, "--light-distance", near, "--light-size", "0", "--ambient", "0", "--light-azimuth", kLightAzimuth, "--light-elevation", kLightElevation]);
      // Not where the lamp grazes: there three.js casts no shadow.
      const to_lamp = (seen) => (near ? unit(along(near, seen.n.map((v) => -v), kLamp)) : kLamp), is_lit = (seen) => dot(seen.n, to_lamp(seen)) > 0.1;
      const plain = differences(ours, (i, c, seen) => (is_lit(seen) ? whole[i] : undefined));
      const lamp_off = differences(ours, (i, c, seen) => {
        if (!is_lit(seen)) return undefined;
        const e = energy(seen);
        return matt[i] * diffuse_left(e, c) + (whole[i] - matt[i]) * schlick_over_fit(f0(c), seen, to_lamp(seen)) * (1 + f0(c) * (1 / (e.scale + e.bias) - 1));
      });
      console.log(`${material.name}, ${near ? "near lamp" : "lamp"}: as three.js draws it ${plain.mean.toFixed(2)} codes off (at most ${plain.most.toFixed(1)}); with the energy that it leaves out ${lamp_off.mean.toFixed(2)} (${lamp_off.most.toFixed(1)})`);
      // Rounding to 8 bits is half a code; the program's table of the energy is good to half a percent, 0.6 codes of the brightest.
      assert.ok(lamp_off.excess <= 0, `${material.name} under a ${near ? "near " : ""}lamp: ${lamp_off.excess} codes over the bound`);
    }

    // Surroundings, against the integral over them; three.js has fits and a blurred picture in its place.
    ours = await draw_ours(page, folder, material, ["--environment", "sky.hdr", "--environment-light", "0"]);
    const integral = (i, c, { n, view }) => {
      const cosine = dot(n, view), e = lobe_integrals(material.roughness, cosine), across = unit(along(-cosine, view, n));
      const part = (name) => f0(c) * e[`scale${name}`] + e[`bias${name}`];
      const mirror = kSky.mean * part("") + dot(kSky.slope, across) * part("_across") + dot(kSky.slope, n) * part("_up");
      const diffuse = (1 - m) * material.color[c] * diffuse_left(e, c) * (kSky.mean + (2 / 3) * dot(kSky.slope, n));
      return diffuse + (1 + f0(c) * (1 / (e.scale + e.bias) - 1)) * mirror;
    };
    const theirs = await draw_three(page, material, { sky: sky_of_three(), width: 64, height: 32 });
    const sky_off = differences(ours, integral), their_off = differences(theirs.map(code), integral), between = differences(ours, (i) => theirs[i]);
    console.log(`${material.name}, surroundings: ${sky_off.mean.toFixed(2)} codes off the integral (at most ${sky_off.most.toFixed(1)}), three.js ${their_off.mean.toFixed(2)} (${their_off.most.toFixed(1)}); ${between.mean.toFixed(2)} between them (${between.most.toFixed(1)})`);
    // The rays of a mirror are few in a pixel: its mean is asked for, and three.js's fits are farther off.
    assert.ok(sky_off.mean < 0.5 + 1.0, `${material.name} under a sky: ${sky_off.mean} codes`);
    assert.ok(sky_off.mean < their_off.mean + 0.5, `${material.name} under a sky: three.js is nearer to the integral`);
  }
} finally {
  await browser.close();
  await rm(folder, { recursive: true });
}
