// What an exchange on a device works on, in the dialect of kernel_language.inl.

typedef struct ExchangeCall {
  u64 seed, random_key;
  double ratio, contact, contact_area;
  double rates[8];   // By active material,
  u32 materials[8];  // which of all it is.
  u32 num_active;
  u32 random_piece;  // Which random numbers of a gammaton are used.
  u32 is_deposit;
  u32 is_wide;     // Splats; else contacts are of one texel.
  u32 num_texels;  // Of a material's plane of amounts.
  i32 width;       // Of the atlas, texels.
} ExchangeCall;

// A contact and its splat, or an ending and its trail.
typedef struct SplatContact {
  u32 texel;  // Its middle, or end.
  u32 gammaton;
  u32 first_part, num_parts;  // Of a stencil's parts, or where it is cut of what the CPU has cut.
  u32 first_piece;            // Of the batch's.
  u32 is_cut;
} SplatContact;

// Of a stencil, the middle first.
typedef struct StencilPart {
  i32 x, y;  // Texels from the middle.
  u32 share;
} StencilPart;

typedef struct CutPart {
  u32 texel, share;
} CutPart;

// A part of a splat that exchanges on its own; its texel is kNoPiece where there is none.
typedef struct SplatPiece {
  u32 texel;
  u32 contact;  // Of the batch's.
  u32 number;   // In its splat; 0 = middle.
  u32 share;
} SplatPiece;

PATINATE_CONSTANT(u32, kNoPiece, 0xFFFFFFFFu);
