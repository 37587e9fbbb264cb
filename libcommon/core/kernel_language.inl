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
#define PATINATE_SQRT(x) sqrt(x)
#define PATINATE_SQRTF(x) sqrt(x)
#define PATINATE_AS_FLOAT(bits) as_float(bits)
#define PATINATE_AS_DOUBLE(bits) as_double(bits)
#define PATINATE_FLOAT_BITS(x) as_uint(x)
#define PATINATE_DOUBLE_BITS(x) as_ulong(x)
#else
#define PATINATE_GLOBAL
#define PATINATE_SQRT(x) __builtin_sqrt(x)
#define PATINATE_SQRTF(x) __builtin_sqrtf(x)
#define PATINATE_AS_FLOAT(bits) __builtin_bit_cast(float, bits)
#define PATINATE_AS_DOUBLE(bits) __builtin_bit_cast(double, bits)
#define PATINATE_FLOAT_BITS(x) __builtin_bit_cast(u32, x)
#define PATINATE_DOUBLE_BITS(x) __builtin_bit_cast(u64, x)
#endif
