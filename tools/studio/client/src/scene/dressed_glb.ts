// A GLB as other viewers show it: with the materials and looks that are in it.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { get, StudioError, url_of } from "../api";

const kMmPerMeter = 1000;

export interface DressedGlb {
  group: THREE.Group;
  /// The looks that it holds (KHR_materials_variants); the first one is shown.
  variants: string[];
  show(variant: string): Promise<void>;
}

interface Variants {
  variants?: { name: string }[];
  mappings?: { variants: number[]; material: number }[];
}

function variants_of(holder: { userData: Record<string, unknown> }): Variants {
  return (holder.userData["gltfExtensions"] as Record<string, Variants> | undefined)?.["KHR_materials_variants"] ?? {};
}

function meshes_of(group: THREE.Object3D): THREE.Mesh[] {
  const meshes: THREE.Mesh[] = [];
  group.traverse((o) => { if (o instanceof THREE.Mesh) meshes.push(o); });
  return meshes;
}

/// @param place  The file. @throws StudioError
export async function read_dressed_glb(place: string, signal?: AbortSignal): Promise<DressedGlb> {
  const file = await get(url_of("/api/file", { place, path: place.split("/").pop() }), signal);
  const loader = new GLTFLoader();
  // Pictures come from within the file, as images: the page's security policy lets it fetch nothing else.
  loader.register((parser) => {
    parser.textureLoader = new THREE.TextureLoader(parser.options.manager);
    return { name: "patinate pictures" };
  });
  const gltf = await loader.parseAsync(file.bytes, "").catch((error: Error) => {
    throw new StudioError(`The model cannot be shown: ${error.message}`);
  });
  const group = gltf.scene;
  group.scale.setScalar(kMmPerMeter);
  for (const mesh of meshes_of(group)) mesh.castShadow = mesh.receiveShadow = true;
  const variants = (variants_of(gltf).variants ?? []).map((v) => v.name);
  return {
    group, variants,
    show: async (variant) => {
      for (const mesh of meshes_of(group)) {
        const found = variants_of(mesh).mappings?.find((m) => m.variants.includes(variants.indexOf(variant)));
        if (found) mesh.material = await gltf.parser.getDependency("material", found.material) as THREE.Material;
      }
    },
  };
}
