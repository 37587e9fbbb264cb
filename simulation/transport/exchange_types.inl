// What an exchange on a device works on, in the dialect of kernel_language.inl.

typedef struct ExchangeCall {
  u64 seed, random_key;
  double ratio, contact, contact_area;
  double width;      // Of a splat, in texels of median size; 0: contacts are of one texel.
  double rates[8];   // By active material,
  u32 materials[8];  // which of all it is.
  u32 num_active;
  u32 num_materials;
  u32 random_piece;  // Which random numbers of a gammaton are used.
  u32 phase;         // Of tally_types.inl.
  u32 num_texels;    // Of a material's plane of amounts.
  i32 atlas_width;   // Texels.
  i32 iteration;
  u32 most_pieces;  // That there is room for.
  u32 most_walks, most_walked;
  u32 most_links;  // Of a texel.
  u32 num_slots;   // For tiles that a trail touches: a power of two.
  u32 maps;        // kMapHits and so on are kept;
  u32 map_of[8];   // by material: 1 + its plane among those of deposited mass; 0 = none.
} ExchangeCall;

enum { kMapHits = 1, kMapLast = 2, kMapResidence = 4 };

// By size of a splat: its stencil.
typedef struct StencilFacts {
  u32 first, num;  // Of all parts, the middle first.
  i32 reach;       // Texels that it goes to each side.
} StencilFacts;

typedef struct StencilPart {
  i32 x, y;  // Texels from the middle.
  u32 share;
} StencilPart;

typedef struct SurfaceLink {
  u32 texel, count;
} SurfaceLink;

// A part of a splat that exchanges on its own.
typedef struct SplatPiece {
  u32 texel;
  u32 gammaton;
  u32 number;  // In its splat; 0 = middle.
  u32 share;
} SplatPiece;

PATINATE_CONSTANT(u32, kNoPiece, 0xFFFFFFFFu);

// A splat near a seam, or a place of a trail there, and where its parts are.
typedef struct Walk {
  u32 texel;
  i32 size;
  u32 first, num;
} Walk;

// A place of a trail.
typedef struct TrailPlace {
  u32 texel, share;
  i32 size;
  u32 walk;  // kNoPiece: a stencil lays it out.
} TrailPlace;

// What a group that walks needs in global memory: by edge.
typedef struct WalkRoom {
  double flow[6 * 720], goes[6 * 720];
} WalkRoom;
