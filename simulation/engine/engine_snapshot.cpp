#include <algorithm>
#include <cmath>

#include "patinate/core/error.h"
#include "simulation/engine/byte_stream.h"
#include "simulation/engine/engine_state.h"
#include "simulation/rules/initial_layers.h"

namespace patinate::simulation {

namespace {

constexpr std::uint64_t kMagic = 0x35304E5354415050ull;          // "PPATSN05": raised with every change of what follows
constexpr std::uint64_t kMagicOfLayers = 0x36304E5354415050ull;  // "PPATSN06": of a scene with layers, and only of such
constexpr std::uint64_t kMagicOfCracks = 0x37304E5354415050ull;  // "PPATSN07": of one in which layers crack
constexpr std::uint64_t kMagicBeforeMet = 0x34304E5354415050ull;      // "PPATSN04": without where gammatons have been
constexpr std::uint64_t kMagicBeforeWeather = 0x33304E5354415050ull;  // "PPATSN03": without weather, series, trails
constexpr std::uint64_t kMagicBeforePaint = 0x32304E5354415050ull;    // "PPATSN02": without num_paint_steps

std::uint64_t magic_of(const LayerAtlas* layers) {
  return layers == nullptr ? kMagic : layers->has_cracks() ? kMagicOfCracks : kMagicOfLayers;
}

/// f(value) for every number of what a rule does to layers. @param with_stress  Some of them crack.
template <class R, class F>
void for_each_share(R& rule, bool with_stress, F&& f) {
  for (auto* shares : {&rule.layer_products, &rule.layer_reactants}) {
    for (auto& x : shares->at_interface) f(x);
    f(shares->thickness_um);
    f(shares->adhesion);
    if (with_stress) f(shares->stress);
  }
}

void write_shares(ByteWriter& out, const Rule& rule, bool with_stress) {
  out.text(rule.layer);
  for_each_share(rule, with_stress, [&](double x) { out.value(x); });
}

/// Emitters, places, behavior, exchange and rules: what events change.
void write_scene(ByteWriter& out, const Scene& scene) {
  for (const SceneObject& o : scene.objects) {
    for (const Vec3& v : {o.translate_mm, o.rotate_deg}) {
      for (const double x : v) out.value(x);
    }
    out.value(o.scale);
  }
  out.value(static_cast<std::uint64_t>(scene.emitters.size()));
  for (const Emitter& e : scene.emitters) {
    out.value(static_cast<std::int32_t>(e.shape));
    for (const Vec3& v : {e.position_mm, e.direction}) {
      for (const double x : v) out.value(x);
    }
    for (const double x : {e.size_mm[0], e.size_mm[1], e.spread_deg, e.speed_mm_s, e.distance_mm}) out.value(x);
    for (const double x : e.carries) out.value(x);
    out.value(static_cast<std::uint8_t>(e.is_on));
    out.value(static_cast<std::int32_t>(e.follows ? static_cast<int>(*e.follows) : -1));
    out.value(e.full_at);
  }
  const Behavior& b = scene.behavior;
  for (const double x :
       {b.bounce, b.floating, b.absorb, b.deceleration_bounce, b.deceleration_float, scene.exchange.ratio})
    out.value(x);
  for (const double x : scene.exchange.rates) out.value(x);
  out.value(static_cast<std::uint64_t>(scene.rules.size()));
  for (const Rule& rule : scene.rules) {
    out.text(rule.name);
    out.text(rule.driver);
    out.value(rule.rate);
    for (const double x : rule.products) out.value(x);
    for (const double x : rule.reactants) out.value(x);
    out.text(rule.where);
    if (has_layers(scene)) write_shares(out, rule, has_cracks(scene));
  }
}

std::vector<Rule> read_rules(ByteReader& in, bool has_weather, const Scene& scene) {
  const auto count = in.value<std::uint64_t>();
  if (count > kMaxRules) throw InvalidInput("the snapshot is damaged");
  std::vector<Rule> rules(static_cast<std::size_t>(count));
  for (Rule& rule : rules) {
    rule.name = in.text();
    rule.driver = in.text();
    in.value(rule.rate);
    for (double& x : rule.products) in.value(x);
    for (double& x : rule.reactants) in.value(x);
    if (has_weather) rule.where = in.text();
    if (!has_layers(scene)) continue;
    rule.layer = in.text();
    for_each_share(rule, has_cracks(scene), [&](double& x) { in.value(x); });
  }
  return rules;
}

/// @returns how many emitters the snapshot has: the scene's first ones.
std::size_t read_scene_values(ByteReader& in, Scene& scene, bool has_weather) {
  const auto vector = [&](Vec3& v) {
    for (double& x : v) in.value(x);
  };
  for (SceneObject& o : scene.objects) {
    vector(o.translate_mm);
    vector(o.rotate_deg);
    in.value(o.scale);
  }
  const auto num_emitters = in.value<std::uint64_t>();
  if (num_emitters < 1 || num_emitters > scene.emitters.size()) throw InvalidInput("the snapshot is of another scene");
  for (Emitter& e : std::span(scene.emitters).first(static_cast<std::size_t>(num_emitters))) {
    const auto shape = in.value<std::int32_t>();
    if (shape < 0 || shape >= static_cast<std::int32_t>(kEmitterShapeNames.size()))
      throw InvalidInput("the snapshot is damaged");
    e.shape = static_cast<EmitterShape>(shape);
    vector(e.position_mm);
    vector(e.direction);
    for (double* x : {&e.size_mm[0], &e.size_mm[1], &e.spread_deg, &e.speed_mm_s, &e.distance_mm}) in.value(*x);
    for (double& x : e.carries) in.value(x);
    e.is_on = in.value<std::uint8_t>() != 0;
    if (!has_weather) continue;
    const auto follows = in.value<std::int32_t>();
    if (follows < -1 || follows >= static_cast<std::int32_t>(kNumWeatherSignals))
      throw InvalidInput("the snapshot is damaged");
    e.follows = follows < 0 ? std::nullopt : std::optional(static_cast<WeatherSignal>(follows));
    in.value(e.full_at);
  }
  Behavior& b = scene.behavior;
  for (double* x :
       {&b.bounce, &b.floating, &b.absorb, &b.deceleration_bounce, &b.deceleration_float, &scene.exchange.ratio})
    in.value(*x);
  for (double& x : scene.exchange.rates) in.value(x);
  scene.rules = read_rules(in, has_weather, scene);
  return static_cast<std::size_t>(num_emitters);
}

void write_atlas(ByteWriter& out, const MaterialAtlas& atlas) {
  for (int m = 0; m < atlas.num_materials(); ++m) {
    for (std::uint32_t p = 0; p < atlas.surface().grid().num_pages(); ++p) {
      const std::span<const std::uint16_t> page = atlas.page(m, p);
      out.value(static_cast<std::uint8_t>(!page.empty()));
      if (!page.empty()) out.array(page);
    }
  }
}

void read_atlas(ByteReader& in, MaterialAtlas& atlas) {
  for (int m = 0; m < atlas.num_materials(); ++m) {
    for (std::uint32_t p = 0; p < atlas.surface().grid().num_pages(); ++p) {
      if (in.value<std::uint8_t>() == 0) continue;
      const std::span<std::uint16_t> first = atlas.writable_tile(m, p * TileGrid::kPageTiles);
      in.fill(
          std::span<std::uint16_t>(first.data(), TileGrid::kPageTexels));  // the tiles of a page lie one after another
    }
  }
}

/// All planes of layers. @param f  f(atlas of planes).
template <class Layers, class F>
void for_each_plane(Layers& layers, F&& f) {
  f(layers.thickness());
  f(layers.adhesion());
  f(layers.stress());
  f(layers.next_look());
  f(layers.crack());
  for (int l = 1; l < layers.num_layers(); ++l) f(layers.interface_below(l));
}

void write_layers(ByteWriter& out, const LayerAtlas& layers) {
  for_each_plane(layers, [&](const MaterialAtlas& plane) { write_atlas(out, plane); });
  for (const LayerAccount& account : layers.accounts()) {
    for (const MassSum* sum : {&account.start, &account.worn, &account.flaked}) {
      out.value(sum->high());
      out.value(sum->low());
    }
  }
  if (layers.has_cracks()) out.array(layers.tips());
}

bool are_in(const std::vector<CrackTip>& tips, const LayerAtlas& layers) {
  const SurfaceAtlas& surface = layers.surface();
  return std::all_of(tips.begin(), tips.end(), [&](const CrackTip& tip) {
    if (tip.texel >= surface.grid().num_texels() || !surface.is_covered(tip.texel)) return false;
    const int object = surface.object(surface.triangle(tip.texel));
    const std::array<float, 2> lag{tip.place[0] - static_cast<float>(surface.grid().x(tip.texel)),
                                   tip.place[1] - static_cast<float>(surface.grid().y(tip.texel))};
    const float length = tip.way[0] * tip.way[0] + tip.way[1] * tip.way[1];
    return tip.layer >= 1 && static_cast<int>(tip.layer) < layers.num_layers(object) &&
           layers.cracks(object, static_cast<int>(tip.layer)) && lag[0] >= 0.0F && lag[0] <= 1.0F && lag[1] >= 0.0F &&
           lag[1] <= 1.0F && std::abs(length - 1.0F) < 1e-3F;
  });
}

/// @param layers  As the scene makes them, without the maps of their thickness.
void read_layers(ByteReader& in, LayerAtlas& layers) {
  for_each_plane(layers, [&](MaterialAtlas& plane) { read_atlas(in, plane); });
  for (LayerAccount& account : layers.accounts()) {
    for (MassSum* sum : {&account.start, &account.worn, &account.flaked}) {
      const auto high = in.value<std::int64_t>();
      *sum = MassSum::from_parts(high, in.value<std::uint32_t>());
    }
  }
  if (layers.has_cracks()) in.array(layers.tips());
  if (!are_in(layers.tips(), layers)) throw InvalidInput("the snapshot is damaged, or of another scene");
  layers.renew_tops();
}

/// f(values) for each map that is kept.
template <class Maps, class F>
void for_each_map(Maps& maps, F&& f) {
  if (auto* values = maps.hits()) f(*values);
  if (auto* values = maps.last_hit()) f(*values);
  if (auto* values = maps.residence()) f(*values);
  for (int m = 0; m < kMaxMaterials; ++m) {
    if (auto* values = maps.deposited(m)) f(*values);
  }
}

void write_ledger(ByteWriter& out, const MassLedger& ledger) {
  for (int m = 0; m < kMaxMaterials; ++m) {
    const MassAccount& a = ledger.account(m);
    for (const MassSum* sum :
         {&a.emitted, &a.on_surfaces, &a.carried, &a.left, &a.absorbed, &a.rested, &a.made, &a.used}) {
      out.value(sum->high());
      out.value(sum->low());
    }
  }
}

void read_ledger(ByteReader& in, MassLedger& ledger) {
  for (int m = 0; m < kMaxMaterials; ++m) {
    MassAccount& a = ledger.account(m);
    for (MassSum* sum : {&a.emitted, &a.on_surfaces, &a.carried, &a.left, &a.absorbed, &a.rested, &a.made, &a.used}) {
      const auto high = in.value<std::int64_t>();
      const auto low = in.value<std::uint32_t>();
      *sum = MassSum::from_parts(high, low);
    }
  }
}

/// Checks that all that gammatons name is there. @throws InvalidInput
void check_gammatons(const Gammatons& g, std::size_t num, const Scene& scene, int num_triangles) {
  bool is_right = g.state.size() == num && g.is_front.size() == num && g.emitter.size() == num &&
                  g.num_births.size() == num && g.triangle.size() == num && g.b1.size() == num && g.b2.size() == num &&
                  g.position.size() == num && g.velocity.size() == num;
  for (std::size_t i = 0; is_right && i < num; ++i) {
    const bool has_place = g.state[i] == GammatonState::Floating || g.state[i] == GammatonState::InContact;
    is_right = g.state[i] <= GammatonState::InContact && g.emitter[i] < scene.emitters.size() &&
               g.triangle[i] >= (has_place ? 0 : -1) && g.triangle[i] < num_triangles && g.b1[i] >= 0.0 &&
               g.b2[i] >= 0.0 && g.b1[i] + g.b2[i] <= 1.0 + 1e-9 && g.position[i].allFinite() &&
               g.velocity[i].allFinite();
  }
  if (!is_right) throw InvalidInput("the snapshot is damaged, or of another scene");
}

/// Trails of as many gammatons, over texels of the surface.
bool are_in(const std::vector<Trail>& trails, const SurfaceAtlas& surface, std::size_t num) {
  return trails.size() == num && std::all_of(trails.begin(), trails.end(), [&](const Trail& trail) {
           for (std::size_t i = 0; i < trail.size(); ++i) {
             if (trail.texel(i) >= surface.grid().num_texels() || !surface.is_covered(trail.texel(i))) return false;
           }
           return true;
         });
}

/// Nothing where whoever wrote the snapshot did not know.
std::optional<MetTexels> read_met(ByteReader& in, const TileGrid& grid) {
  std::vector<std::uint64_t> tiles;
  in.array(tiles);
  if (tiles.empty()) return std::nullopt;
  MetTexels met(grid);
  if (tiles.size() != met.tiles().size()) throw InvalidInput("the snapshot is damaged, or of another scene");
  std::copy(tiles.begin(), tiles.end(), met.tiles().begin());
  return met;
}

/// Gammatons of emitters that the snapshot does not have: they wait, as in any scene whose last emitters are off from
/// the start.
void add_waiting(const Scene& scene, Gammatons& gammatons) {
  const std::size_t known = gammatons.size();
  Gammatons all = make_gammatons(scene);
  std::vector<void*> arrays;
  all.for_each_array([&](const char*, auto& array) { arrays.push_back(&array); });
  std::size_t i = 0;
  gammatons.for_each_array([&](const char*, auto& array) {
    const auto& from = *static_cast<std::remove_reference_t<decltype(array)>*>(arrays[i++]);
    array.insert(array.end(), from.begin() + static_cast<std::ptrdiff_t>(known), from.end());
  });
}

}  // namespace

std::vector<std::byte> Simulation::snapshot() const {
  state_->copy_to_host();
  const State& s = *state_;
  ByteWriter out;
  const std::uint64_t magic = magic_of(s.layers.get());
  out.value(magic);
  out.value(static_cast<std::int32_t>(s.scene.resolution));
  out.value(static_cast<std::int32_t>(s.scene.materials.size()));
  out.value(s.iteration);
  out.value(s.num_paint_steps);
  out.value(static_cast<std::uint64_t>(s.next_event));
  out.value(s.series_done);
  write_scene(out, s.scene);
  write_atlas(out, s.atlas);
  Gammatons& gammatons =
      const_cast<Gammatons&>(s.gammatons);  // for_each_array gives both readers and writers their arrays
  gammatons.for_each_array([&](const char*, const auto& array) {
    if constexpr (std::is_same_v<decltype(array), const std::vector<Vec3>&>) {
      out.array(std::span<const double>(array.empty() ? nullptr : array.front().data(), 3 * array.size()));
    } else {
      out.array(array);
    }
  });
  out.array(s.cargo.mass);
  for_each_map(*s.maps, [&](const auto& values) {
    for (std::uint32_t p = 0; p < values.num_pages(); ++p) {
      out.value(static_cast<std::uint8_t>(!values.page(p).empty()));
      if (!values.page(p).empty()) out.array(values.page(p));
    }
  });
  write_ledger(out, s.ledger);
  out.value(s.counters);
  out.array(s.trails);
  out.array(s.met ? s.met->tiles() : std::span<const std::uint64_t>());
  if (s.layers) write_layers(out, *s.layers);
  out.value(magic);
  return out.take();
}

void Simulation::restore(std::span<const std::byte> bytes) {
  State& s = *state_;
  s.copy_to_host();
  ByteReader in(bytes);
  const auto expect = [&](auto value) {
    if (in.value<decltype(value)>() != value) throw InvalidInput("the snapshot is of another version or scene");
  };
  const auto magic = in.value<std::uint64_t>();
  const bool is_newest = magic == magic_of(s.layers.get());
  if (s.layers && !is_newest) throw InvalidInput("the snapshot is of another version or scene");
  const bool has_weather = is_newest || magic == kMagicBeforeMet;
  if (!has_weather && magic != kMagicBeforeWeather && magic != kMagicBeforePaint)
    throw InvalidInput("the snapshot is of another version or scene");
  expect(static_cast<std::int32_t>(s.scene.resolution));
  expect(static_cast<std::int32_t>(s.scene.materials.size()));
  if (bytes.size() < sizeof(magic) ||
      !std::equal(bytes.end() - sizeof(magic), bytes.end(), std::as_bytes(std::span(&magic, 1)).begin())) {
    throw InvalidInput("the snapshot is cut short");
  }
  const auto iteration = in.value<std::int64_t>();
  const auto num_paint_steps = magic != kMagicBeforePaint ? in.value<std::int64_t>() : 0;
  const auto next_event = in.value<std::uint64_t>();
  const auto series_done = has_weather ? in.value<std::int64_t>() : iteration - 1;
  Scene scene = s.scene;
  const std::size_t num_emitters = read_scene_values(in, scene, has_weather);
  check_scene(scene);
  if (iteration < 0 || num_paint_steps < 0 || next_event > scene.events.size())
    throw InvalidInput("the snapshot is damaged, or of another scene");
  MaterialAtlas atlas(s.surface, s.atlas.num_materials(), originals_of(s.scene));
  read_atlas(in, atlas);
  Gammatons gammatons;
  gammatons.for_each_array([&](const char*, auto& array) {
    if constexpr (std::is_same_v<decltype(array), std::vector<Vec3>&>) {
      std::vector<double> numbers;
      in.array(numbers);
      for (std::size_t i = 0; i + 2 < numbers.size(); i += 3)
        array.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    } else {
      in.array(array);
    }
  });
  std::int64_t num_gammatons = 0;
  for (const Emitter& e : std::span(scene.emitters).first(num_emitters)) num_gammatons += e.gammatons;
  check_gammatons(gammatons, static_cast<std::size_t>(num_gammatons), scene, s.surface.num_triangles());
  Cargo cargo;
  in.array(cargo.mass);
  if (cargo.mass.size() != gammatons.size()) throw InvalidInput("the snapshot is damaged, or of another scene");
  add_waiting(scene, gammatons);
  cargo.mass.resize(gammatons.size());
  auto maps = std::make_unique<ParameterMaps>(s.surface.grid(), s.maps->choice());
  for_each_map(*maps, [&](auto& values) {
    for (std::uint32_t p = 0; p < values.num_pages(); ++p) {
      if (in.value<std::uint8_t>() != 0) in.fill(values.writable_page(p));
    }
  });
  MassLedger ledger;
  read_ledger(in, ledger);
  const auto counters = in.value<TraceCounters>();
  std::vector<Trail> trails;
  if (has_weather) in.array(trails);
  if (has_weather && !are_in(trails, s.surface, static_cast<std::size_t>(num_gammatons)))
    throw InvalidInput("the snapshot is damaged, or of another scene");
  trails.resize(gammatons.size());
  std::optional<MetTexels> met = is_newest ? read_met(in, s.surface.grid()) : std::nullopt;
  std::optional<LayerAtlas> layers;
  if (s.layers) read_layers(in, layers.emplace(s.surface, s.scene));
  expect(magic);
  in.finish();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) s.check_scale(i, scene.objects[i].scale);
  s.set_rules(scene.rules);
  s.move_objects(scene);  // before the ledger, which knows of it
  s.scene = std::move(scene);
  s.atlas = std::move(atlas);
  if (layers) replace_layers(std::move(*layers), *s.layers);
  s.ledger = ledger;
  s.counters = counters;
  s.gammatons = std::move(gammatons);
  s.cargo = std::move(cargo);
  s.trails = std::move(trails);
  s.met = std::move(met);
  s.maps = std::move(maps);
  s.iteration = iteration;
  s.num_paint_steps = num_paint_steps;
  s.next_event = static_cast<std::size_t>(next_event);
  s.series_done = series_done;
  s.composed_at = -1;  // an earlier iteration, perhaps: nothing that was composed holds
  s.wake_everything();
  s.there.reset();
  s.composer.forget_there();
  s.is_composed_there = false;
}

}  // namespace patinate::simulation
