// The dialect that kernels are written in: what C++ and OpenCL C 1.2 both read. This text is put before every program
// of a device, and kernel_language.h includes it for C++. No float is contracted, no function of a math library called
// but square roots, which round correctly.
//
// A kernel's text holds functions over PATINATE_GLOBAL pointers and plain structs, and below `#ifdef
// __OPENCL_VERSION__` the entries (`kernel void`) that pick a device's items.
#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#ifdef cl_khr_fp64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif
typedef char i8;
typedef uchar u8;
typedef short i16;
typedef ushort u16;
typedef int i32;
typedef uint u32;
typedef long i64;
typedef ulong u64;
#define PATINATE_GLOBAL __global
#define PATINATE_LOCAL __local
#define PATINATE_RESTRICT restrict
#define PATINATE_INLINE static inline
#define PATINATE_CONSTANT(type, name, value) __constant const type name = value
#define PATINATE_MEMBER(type, name, value) type name
#define PATINATE_ARRAY(type, name, size) type name[size]
#define PATINATE_SQRT(x) sqrt(x)
#define PATINATE_SQRTF(x) sqrt(x)
#define PATINATE_AS_FLOAT(bits) as_float(bits)
#define PATINATE_AS_DOUBLE(bits) as_double(bits)
#define PATINATE_FLOAT_BITS(x) as_uint(x)
#define PATINATE_DOUBLE_BITS(x) as_ulong(x)
#define PATINATE_MAGNITUDE(x) as_double(as_ulong(x) & 0x7FFFFFFFFFFFFFFFul)
#define PATINATE_ALIGNED_TO(bytes) __attribute__((aligned(bytes)))
#define PATINATE_LOWEST_BIT(x) (31u - clz((x) & (0u - (x))))
#define PATINATE_NUM_BITS(x) ((i32)popcount(x))
#define PATINATE_PREFETCH(p)
#else
#define PATINATE_GLOBAL
// Of what the items of a group share on a device.
#define PATINATE_LOCAL
#define PATINATE_RESTRICT __restrict
// Of kernels that stand in headers; those that are compiled for several instruction sets are static.
#define PATINATE_INLINE inline
#define PATINATE_CONSTANT(type, name, value) inline constexpr type name = value
// Members of structs, with what C++ begins them with, and arrays that are values.
#define PATINATE_MEMBER(type, name, value) type name = value
#define PATINATE_ARRAY(type, name, size) \
  std::array<type, size> name {}
#define PATINATE_SQRT(x) __builtin_sqrt(x)
#define PATINATE_SQRTF(x) __builtin_sqrtf(x)
#define PATINATE_AS_FLOAT(bits) __builtin_bit_cast(float, bits)
#define PATINATE_AS_DOUBLE(bits) __builtin_bit_cast(double, bits)
#define PATINATE_FLOAT_BITS(x) __builtin_bit_cast(u32, x)
#define PATINATE_DOUBLE_BITS(x) __builtin_bit_cast(u64, x)
#define PATINATE_MAGNITUDE(x) __builtin_fabs(x)
#define PATINATE_ALIGNED_TO(bytes) alignas(bytes)
// Its place in a u32 that is not 0.
#define PATINATE_LOWEST_BIT(x) static_cast<u32>(__builtin_ctz(x))
// Of a u64.
#define PATINATE_NUM_BITS(x) __builtin_popcountll(x)
// Asks for a line of memory that will be needed soon.
#define PATINATE_PREFETCH(p) __builtin_prefetch(p)
#endif

// Tiles of 64 lanes. The CPU takes a tile at a time, in plain loops that compilers turn into vector code: what a lane
// has of its own is an array of PATINATE_LANES, of which it uses [PATINATE_OWN(l)]. A device has an item for each lane.
#ifdef __OPENCL_VERSION__
#define PATINATE_LANES 1
#define PATINATE_OWN(l) 0
#define PATINATE_EACH_LANE(l) for (i32 l = (i32)(get_global_id(0) & 63u), l##_next = 1; l##_next != 0; l##_next = 0)
#define PATINATE_ALIGNED
#else
#define PATINATE_LANES 64
#define PATINATE_OWN(l) (l)
#define PATINATE_EACH_LANE(l) for (i32 l = 0; l < 64; ++l)
#define PATINATE_ALIGNED alignas(64)
#endif
