// The entry of rule_kernel.inl: a group of 64 items a tile, an item a texel.

static inline float value_of(const float* own, global const float* everywhere, uint i) {
  return i < kFirstShared ? own[i] : everywhere[i - kFirstShared];
}

static inline float step_value(uint kind, float a, float b, float c) {
  switch (kind) {
    case kStepAdd:
      return step_add(a, b);
    case kStepSubtract:
      return step_subtract(a, b);
    case kStepMultiply:
      return step_multiply(a, b);
    case kStepDivide:
      return step_divide(a, b);
    case kStepNegate:
      return step_negate(a);
    case kStepInvert:
      return step_invert(a);
    case kStepMin:
      return step_min(a, b);
    case kStepMax:
      return step_max(a, b);
    case kStepAbs:
      return step_abs(a);
    case kStepPow:
      return step_pow(a, b);
    case kStepClamp:
      return step_clamp(a, b, c);
    default:
      return step_smoothstep(a, b, c);
  }
}

static inline float parameter_at(global const ParameterCodes* parameter, global const uchar* codes, ulong texel) {
  global const uchar* values = codes + parameter->first;
  switch (parameter->bytes_each) {
    case 1:
      return decoded(values[texel], parameter->low, parameter->step);
    case 2:
      return decoded(((global const ushort*)values)[texel], parameter->low, parameter->step);
    default:
      return ((global const float*)values)[texel];
  }
}

// planes: amounts of all materials, num_texels each; materials: by slot; outcomes: by tile, bit 0: a rule has an extent; bit 1 + slot: it was changed;
// sums: by slot, what was made, what was used.
kernel void age_tiles(global const uint* tiles, global const PackedRule* rules, const int num_rules,
                      global const DriverStep* steps, global const float* everywhere,
                      global const ParameterCodes* parameters, const int num_parameters, global const uchar* codes,
                      global const ulong* covered, global const ushort* weights, const int num_slots,
                      global const uint* materials, const uint num_texels, global ushort* planes,
                      global uint* outcomes, global uint* sums) {
  const ulong number = get_global_id(0) / 64u;
  const uint lane = (uint)get_global_id(0) & 63u, tile = tiles[number];
  const ulong texel = (ulong)tile * 64u + lane;
  local uint sum[4 * 8], outcome;
  if (lane < 32u) sum[lane] = 0u;
  if (lane == 0u) outcome = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);

  int quanta[8], changes[16];
  float own[64];  // kFirstShared
  for (int k = 0; k < num_slots; ++k) {
    quanta[k] = planes[(ulong)materials[k] * num_texels + texel];
    own[k] = amount_of(quanta[k]);
  }
  for (int p = 0; p < num_parameters; ++p) own[num_slots + p] = parameter_at(parameters + p, codes, texel);
  const float is_covered = (float)(uint)(covered[tile] >> lane & 1u);
  const uint weight = weights[texel];
  for (int r = 0; r < num_rules; ++r) {
    global const PackedRule* rule = rules + r;
    for (int s = rule->first_step; s < rule->end_step; ++s) {
      global const DriverStep* step = steps + s;
      own[step->out] = step_value(step->kind, value_of(own, everywhere, step->a), value_of(own, everywhere, step->b),
                                  value_of(own, everywhere, step->c));
    }
    const float driver = value_of(own, everywhere, rule->result);
    const int told = apply_rule(&rule->form, &driver, &is_covered, tile * 64u, quanta, own, changes);
    if (told == 0) continue;
    atomic_or(&outcome, told == 3 ? 1u | rule->changes << 1 : 1u);
    for (int k = 0; told == 3 && k < rule->form.num_terms; ++k) {
      const int at = 4 * rule->form.terms[k].material + (k < rule->form.num_makes ? 0 : 2);
      if (changes[k] != 0) add_here(sum + at, (uint)changes[k] * weight, 0u);
    }
  }
  for (int k = 0; k < num_slots; ++k) planes[(ulong)materials[k] * num_texels + texel] = (ushort)quanta[k];

  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u) outcomes[number] = outcome;
  if (lane < 16u && (sum[2u * lane] | sum[2u * lane + 1u]) != 0u)
    add_everywhere(sums + 2u * lane, sum[2u * lane], sum[2u * lane + 1u]);
}
