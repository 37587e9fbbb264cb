// The entry of rule_kernel.inl: a group of 64 items a tile, an item a texel. Behind tally.cl.

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

// due: tiles whose turn it is; planes: amounts of all materials, num_texels each; materials: by slot. Tiles that sleep
// are left out, and fall asleep where no rule has an extent, unless rules go by the age.
kernel void age_due(global const uint* due, global const PackedRule* rules, const int num_rules,
                    global const DriverStep* steps, global const float* everywhere,
                    global const ParameterCodes* parameters, const int num_parameters, global const uchar* codes,
                    global const ulong* covered, global const ushort* weights, const int num_slots,
                    global const uint* materials, const uint num_texels, const int never_sleeps, const int iteration,
                    global ushort* planes, TILE_ARRAYS, global uint* tally) {
  const uint lane = (uint)get_global_id(0) & 63u, tile = due[get_global_id(0) / 64u];
  const ulong texel = (ulong)tile * 64u + lane;
  const Tiles tiles = {dirty, changed_in, awake, is_listed, touched};
  if (awake[tile] == 0u) return;
  local uint sums[kGroupSums], outcome;
  clear_sums(sums);
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
  uint changed = 0u;
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
    changed |= told == 3 ? 1u | rule->changes << 1 : 1u;
    for (int k = 0; told == 3 && k < rule->form.num_terms; ++k) {
      const uint kind = k < rule->form.num_makes ? kMassMade : kMassUsed;
      if (changes[k] != 0)
        add_here(sums + mass_at(kind, materials[rule->form.terms[k].material]), (uint)changes[k] * weight, 0u);
    }
  }
  if (changed > 1u) {
    for (int k = 0; k < num_slots; ++k) planes[(ulong)materials[k] * num_texels + texel] = (ushort)quanta[k];
  }
  if (changed != 0u) atomic_or(&outcome, changed);

  barrier(CLK_LOCAL_MEM_FENCE);
  if (outcome == 0u) {
    if (lane == 0u && never_sleeps == 0) awake[tile] = 0u;
    return;
  }
  if (lane == 0u && outcome > 1u) {
    uint bits = 0u;
    for (int k = 0; k < num_slots; ++k) bits |= (outcome >> (1 + k) & 1u) << materials[k];
    mark_tile(&tiles, tile, bits, iteration, tally);
  }
  if (outcome > 1u) add_sums(sums, tally);
}
