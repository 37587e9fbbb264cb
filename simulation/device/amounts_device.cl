// Tiles of amounts out of planes and into them: an item a texel, tile after tile, and in each material after material.

kernel void gather_tiles(const uint num_texels, const uint num_materials, global const uint* tiles,
                         global const ushort* planes, global ushort* values) {
  const ulong item = get_global_id(0), plane = item / 64u % num_materials;
  const ulong texel = (ulong)tiles[item / 64u / num_materials] * 64u + (item & 63u);
  values[item] = planes[plane * num_texels + texel];
}

kernel void scatter_tiles(const uint num_texels, const uint num_materials, global const uint* tiles,
                          global const ushort* values, global ushort* planes) {
  const ulong item = get_global_id(0), plane = item / 64u % num_materials;
  const ulong texel = (ulong)tiles[item / 64u / num_materials] * 64u + (item & 63u);
  planes[plane * num_texels + texel] = values[item];
}
