#include "transfer/tiles/tile_files.h"

#include <algorithm>
#include <fstream>

#include "libcommon/core/files.h"
#include "libcommon/job/job.h"

namespace patinate::transfer {

namespace tile_file {

namespace {

Path named(const std::string& name) { return Path(kJobWorkFolder) / "tiles" / name; }
std::string text(std::size_t number) { return std::to_string(number); }
std::string text(int number) { return std::to_string(number); }

}  // namespace

Path texel_counts(int tile) { return named("texels." + text(tile)); }
Path values(std::size_t control, int tile) { return named("values" + text(control) + "." + text(tile)); }
Path sorted(std::size_t control, int tile) { return named("sorted" + text(control) + "." + text(tile)); }
Path targets(std::size_t level, int tile) { return named("level" + text(level) + ".targets." + text(tile)); }
Path links(std::size_t level, int tile) { return named("level" + text(level) + ".links." + text(tile)); }
Path places(std::size_t level, int pass, int tile) {
  return named("level" + text(level) + ".places" + text(pass) + "." + text(tile));
}
Path counts(std::size_t level, int pass, int tile) {
  return named("level" + text(level) + ".counts" + text(pass) + "." + text(tile));
}
Path amounts(std::size_t level, int round, int tile) {
  return named("level" + text(level) + ".amounts" + text(round) + "." + text(tile));
}
Path patience(std::size_t level, int round, int tile) {
  return named("level" + text(level) + ".patience" + text(round) + "." + text(tile));
}
Path borders(std::size_t level, int tile) { return named("level" + text(level) + ".borders." + text(tile)); }
Path moved(std::size_t level, int round, int tile) {
  return named("level" + text(level) + ".moved" + text(round) + "." + text(tile));
}
Path zone_patience(std::size_t level, int round, int tile) {
  return named("level" + text(level) + ".zone_patience" + text(round) + "." + text(tile));
}
Path coarse() { return named("coarse.places"); }
Path similar(std::size_t level) { return named("level" + text(level) + ".similar"); }
Path num_levels() { return named("coarse.levels"); }
Path figures(int tile) { return named("figures." + text(tile)); }

}  // namespace tile_file

namespace {

/// Whole numbers, a vector after its length.
class Numbers {
 public:
  void put(std::int64_t v) { all_.push_back(v); }
  template <class Values>
  void put_all(const Values& values) {
    put(static_cast<std::int64_t>(values.size()));
    all_.insert(all_.end(), values.begin(), values.end());
  }
  void write(const std::filesystem::path& file) const { write_array(file, std::span<const std::int64_t>(all_)); }

  explicit Numbers(const std::filesystem::path& file) {
    const MappedFile mapped(file);
    const auto all = mapped.all<std::int64_t>();
    all_.assign(all.begin(), all.end());
  }
  Numbers() = default;
  [[nodiscard]] std::int64_t take() { return all_.at(next_++); }
  template <class Values>
  void take_all(Values& values) {
    const auto count = static_cast<std::size_t>(take());
    if constexpr (requires { values.resize(count); }) values.resize(count);
    for (auto& v : values) v = static_cast<std::decay_t<decltype(v)>>(take());
  }

 private:
  std::vector<std::int64_t> all_;
  std::size_t next_ = 0;
};

}  // namespace

void write_arrays(const std::filesystem::path& file, std::initializer_list<std::span<const std::byte>> arrays) {
  std::filesystem::create_directories(file.parent_path());
  write_atomically(file, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    for (const auto& a : arrays)
      out.write(reinterpret_cast<const char*>(a.data()), static_cast<std::streamsize>(a.size()));
    if (!out.flush()) throw CannotComplete(file.string() + ": cannot be written; is the disk full?");
  });
}

void write_places(const std::filesystem::path& file, const TexelMap& map, const TexelRect& rect, const PlaceMap& places,
                  std::span<const std::uint8_t> changed_near) {
  std::vector<std::int32_t> pixels;
  std::vector<std::int8_t> beside;
  std::vector<std::uint8_t> changed;
  pixels.reserve(rect.num_texels());
  beside.reserve(2 * static_cast<std::size_t>(rect.num_texels()));
  changed.reserve(rect.num_texels());
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const auto t = static_cast<std::size_t>(TexelId{y} * map.width() + x);
      pixels.push_back(map.is_covered(static_cast<TexelId>(t)) ? places.pixels[t] : -1);
      beside.insert(beside.end(), {places.beside()[2 * t], places.beside()[2 * t + 1]});
      changed.push_back(changed_near.empty() ? std::uint8_t{0} : changed_near[t]);
    }
  }
  write_arrays(file,
               {std::as_bytes(std::span(pixels)), std::as_bytes(std::span(beside)), std::as_bytes(std::span(changed))});
}

namespace {

struct MovedTexel {
  TexelId texel = -1;
  std::int32_t pixel = -1;
  std::int8_t beside_x = 0, beside_y = 0;
  std::int16_t unused = 0;  // Bytes of a file are all said.
};

}  // namespace

void write_moved(const std::filesystem::path& file, std::span<const TexelId> texels, const PlaceMap& places) {
  std::vector<MovedTexel> moved;
  moved.reserve(texels.size());
  for (const TexelId texel : texels) {
    const auto t = static_cast<std::size_t>(texel);
    moved.push_back({texel, places.pixels[t], places.beside()[2 * t], places.beside()[2 * t + 1]});
  }
  write_array(file, std::span<const MovedTexel>(moved));
}

void read_moved(const std::filesystem::path& file, PlaceMap& places, const std::function<bool(TexelId)>& is_wanted) {
  const MappedFile mapped(file);
  for (const MovedTexel& m : mapped.all<MovedTexel>()) {
    if (is_wanted(m.texel)) places.set(m.texel, m.pixel, {m.beside_x, m.beside_y});
  }
}

StoredPlaces::Tile& StoredPlaces::open(int tile) {
  const auto found = tiles_.find(tile);
  if (found != tiles_.end()) return found->second;
  const TexelRect rect = rect_of_(tile);
  const auto n = static_cast<std::size_t>(rect.num_texels());
  MappedFile file(file_of_(tile));
  const auto pixels = file.values<std::int32_t>(0, n);
  const auto beside = file.values<std::int8_t>(4 * n, 2 * n);
  const auto changed_near = file.values<std::uint8_t>(6 * n, n);
  return tiles_.emplace(tile, Tile{rect, std::move(file), pixels, beside, changed_near}).first->second;
}

void StoredPlaces::load(int tile, TexelId t, int x, int y, PlaceMap& places, std::span<std::uint8_t> changed_near) {
  const Tile& stored = open(tile);
  const auto i = static_cast<std::size_t>(std::int64_t{y - stored.rect.y0} * stored.rect.width() + x - stored.rect.x0);
  places.set(t, stored.pixels[i], {stored.beside[2 * i], stored.beside[2 * i + 1]});
  if (!changed_near.empty()) changed_near[t] = stored.changed_near[i];
}

void StoredPlaces::load(int tile, const TexelRect& part, int width, PlaceMap& places,
                        std::span<std::uint8_t> changed_near) {
  const TexelRect& own = open(tile).rect;
  for (int y = std::max(part.y0, own.y0); y < std::min(part.y1, own.y1); ++y) {
    for (int x = std::max(part.x0, own.x0); x < std::min(part.x1, own.x1); ++x)
      load(tile, TexelId{y} * width + x, x, y, places, changed_near);
  }
}

void write_counts(const std::filesystem::path& file, const PlaceCounts& counts) {
  Numbers n;
  n.put(counts.amounts.num_texels);
  n.put_all(counts.uses);
  n.put_all(counts.amounts.uses);
  n.put_all(counts.amounts.has);
  n.write(file);
}

PlaceCounts read_counts(const std::filesystem::path& file) {
  Numbers n(file);
  PlaceCounts counts;
  counts.amounts.num_texels = n.take();
  n.take_all(counts.uses);
  n.take_all(counts.amounts.uses);
  n.take_all(counts.amounts.has);
  return counts;
}

void write_amounts(const std::filesystem::path& file, const Amounts::Counts& counts) {
  Numbers out;
  out.put_all(counts.has);
  out.put_all(counts.uses);
  out.put(counts.num_texels);
  out.write(file);
}

Amounts::Counts read_amounts(const std::filesystem::path& file) {
  Numbers in(file);
  Amounts::Counts counts;
  in.take_all(counts.has);
  in.take_all(counts.uses);
  counts.num_texels = in.take();
  return counts;
}

void write_figures(const std::filesystem::path& file, const EnergyFigures& f) {
  Numbers n;
  for (std::int64_t v : {f.coherence.high, f.coherence.low, f.control.high, f.control.low, f.num_texels, f.difference,
                         f.pairs, f.coherent_pairs})
    n.put(v);
  n.put_all(f.differences);
  n.put_all(f.wanted);
  n.put_all(f.missed);
  n.put_all(f.is_used);
  n.write(file);
}

EnergyFigures read_figures(const std::filesystem::path& file) {
  Numbers n(file);
  EnergyFigures f;
  for (std::int64_t* v : {&f.coherence.high, &f.coherence.low, &f.control.high, &f.control.low, &f.num_texels,
                          &f.difference, &f.pairs, &f.coherent_pairs})
    *v = n.take();
  n.take_all(f.differences);
  n.take_all(f.wanted);
  n.take_all(f.missed);
  n.take_all(f.is_used);
  return f;
}

}  // namespace patinate::transfer
