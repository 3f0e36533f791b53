/* The still life of scenes.py, written by hand for speed: what this machine can do without any culling.
 *
 *     cc -O3 -march=native -ffast-math -include scene.h brute_force.c -o brute_force -lm
 *     ./brute_force WIDTH HEIGHT REPETITIONS EXPOSURE [OUT.ppm]
 *
 * scene.h comes from c_header() of scenes.py: what never changes in the scene is a constant here. For 16 pixels at
 * a time: the rays, all four objects, the nearest hit, its shading, a shadow ray against the other objects,
 * exposure, sRGB, 8 bits. One thread. Nothing is skipped for being out of sight; only where all 16 pixels are
 * black already is the rest left undone. It prints the seconds of the first repetition and of the median one, as
 * JSON.
 *
 * It knows what a renderer cannot: how many objects there are and of what kind, that eye and light are outside of
 * all of them, that nothing overlaps. Its last digits are its compiler's business, and it shows: fused
 * multiply-adds, reciprocal estimates, a polynomial for sRGB that is up to a twelfth of a level off.
 */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* --- As many numbers at a time as a register holds --------------------------------------------------------- */

#if defined(__AVX512F__)
#define LANES 16
#elif defined(__AVX2__)
#define LANES 8
#else
#define LANES 4
#endif

#define BYTES_PER_BLOCK (3 * LANES)

/* With AVX-512 by its intrinsics; else, or with PORTABLE, as plain C vectors that the compiler translates. */

#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512DQ__) && !defined(PORTABLE)

#include <immintrin.h>

#define SIMD "avx512"

typedef __m512 lanes;
typedef __mmask16 mask;

static inline lanes all(float x) { return _mm512_set1_ps(x); }
static inline lanes least(lanes a, lanes b) { return _mm512_min_ps(a, b); }
static inline lanes most(lanes a, lanes b) { return _mm512_max_ps(a, b); }
static inline lanes root(lanes a) { return _mm512_sqrt_ps(a); }
static inline mask below(lanes a, lanes b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
static inline mask at_most(lanes a, lanes b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
static inline mask not(mask a) { return (mask)~a; }
static inline int any(mask a) { return a != 0; }
static inline lanes where(mask m, lanes yes, lanes no) { return _mm512_mask_blend_ps(m, no, yes); }

/* 1 / a and 1 / sqrt(a): the estimates have 14 bits, a step of Newton's method makes that 23. */
static inline lanes inverse(lanes a)
{
    const lanes y = _mm512_rcp14_ps(a);
    return y * (all(2) - a * y);
}

static inline lanes inverse_root(lanes a)
{
    const lanes y = _mm512_rsqrt14_ps(a);
    return y * (all(1.5f) - all(0.5f) * a * y * y);
}

/* sqrt(a) to 14 bits, NaN at 0: enough for 8. */
static inline lanes rough_root(lanes a) { return a * _mm512_rsqrt14_ps(a); }

/* Round to 8 bits and store 16 pixels as RGBRGB... Of each four bytes one is dropped: first within quarters of
 * the register, then the quarters are moved together. */
static inline void store(uint8_t *out, lanes r, lanes g, lanes b)
{
    const __m512i three_of_four = _mm512_broadcast_i32x4(
        _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1));
    const __m512i twelve_of_sixteen =
        _mm512_setr_epi32(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15);
    const __m512i green = _mm512_slli_epi32(_mm512_cvtps_epi32(g), 8);
    const __m512i blue = _mm512_slli_epi32(_mm512_cvtps_epi32(b), 16);
    __m512i rgb = _mm512_or_si512(_mm512_cvtps_epi32(r), _mm512_or_si512(green, blue));
    rgb = _mm512_permutexvar_epi32(twelve_of_sixteen, _mm512_shuffle_epi8(rgb, three_of_four));
    _mm512_mask_storeu_epi32(out, 0x0fff, rgb);
}

#else

#if defined(__AVX512F__)
#define SIMD "avx512 by the compiler"
#elif defined(__AVX2__)
#define SIMD "avx2 by the compiler"
#else
#define SIMD "baseline by the compiler"
#endif

typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t mask __attribute__((vector_size(4 * LANES)));

static inline lanes all(float x) { return x - (lanes){0}; }
static inline mask below(lanes a, lanes b) { return a < b; }
static inline mask at_most(lanes a, lanes b) { return a <= b; }
static inline mask not(mask a) { return ~a; }
static inline lanes where(mask m, lanes yes, lanes no) { return (lanes)((m & (mask)yes) | (~m & (mask)no)); }
static inline lanes least(lanes a, lanes b) { return where(a < b, a, b); }
static inline lanes most(lanes a, lanes b) { return where(a > b, a, b); }

static inline int any(mask a)
{
    int32_t found = 0;
    for (int i = 0; i < LANES; i++)
        found |= a[i];
    return found != 0;
}

static inline lanes root(lanes a)
{
    lanes result;
    for (int i = 0; i < LANES; i++)
        result[i] = sqrtf(a[i]);
    return result;
}

static inline lanes inverse(lanes a) { return 1 / a; }
static inline lanes inverse_root(lanes a) { return 1 / root(a); }
static inline lanes rough_root(lanes a) { return root(a); }

static inline void store(uint8_t *out, lanes r, lanes g, lanes b)
{
    for (int i = 0; i < LANES; i++) {
        out[3 * i] = (uint8_t)(r[i] + 0.5f);
        out[3 * i + 1] = (uint8_t)(g[i] + 0.5f);
        out[3 * i + 2] = (uint8_t)(b[i] + 0.5f);
    }
}

#endif

/* --- Vectors ------------------------------------------------------------------------------------------------ */

typedef struct {
    lanes x, y, z;
} vector;

static inline vector point(float x, float y, float z) { return (vector){all(x), all(y), all(z)}; }
static inline vector minus(vector a, vector b) { return (vector){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vector times(lanes s, vector a) { return (vector){s * a.x, s * a.y, s * a.z}; }
static inline lanes dot(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline vector vector_where(mask m, vector yes, vector no)
{
    return (vector){where(m, yes.x, no.x), where(m, yes.y, no.y), where(m, yes.z, no.z)};
}

/* R_y v: into the axes of the box. */
static inline vector to_box(vector a)
{
    return (vector){BOX_COS * a.x - BOX_SIN * a.z, a.y, BOX_SIN * a.x + BOX_COS * a.z};
}

/* R_y,neg v: back. */
static inline vector from_box(vector a)
{
    return (vector){BOX_COS * a.x + BOX_SIN * a.z, a.y, BOX_COS * a.z - BOX_SIN * a.x};
}

/* --- What rays from the eye meet: d of length 1, the eye is the origin --------------------------------------- */

typedef struct {
    lanes t;
    mask plane, ball, marble, box;
    vector box_normal;
} hits;

/* |t d - C|^2 = R^2, from outside: t = b - sqrt(b^2 - (|C|^2 - R^2)) with b = d . C. */
static inline mask meet_sphere(vector d, vector centre, float radius, lanes *t)
{
    lanes b = dot(d, centre);
    lanes discriminant = b * b - (dot(centre, centre) - radius * radius);
    *t = b - root(most(discriminant, all(0)));
    return below(all(0), discriminant) & below(all(0), b);
}

/* Where lines o + t d, in the axes of the box, enter it and leave it, on each axis. */
static inline void slabs(vector o, vector d, vector *enter, vector *leave)
{
    lanes ix = inverse(d.x), iy = inverse(d.y), iz = inverse(d.z);
    lanes ax = (-BOX_HALF_X - o.x) * ix, bx = (BOX_HALF_X - o.x) * ix;
    lanes ay = (-BOX_HALF_Y - o.y) * iy, by = (BOX_HALF_Y - o.y) * iy;
    lanes az = (-BOX_HALF_Z - o.z) * iz, bz = (BOX_HALF_Z - o.z) * iz;
    *enter = (vector){least(ax, bx), least(ay, by), least(az, bz)};
    *leave = (vector){most(ax, bx), most(ay, by), most(az, bz)};
}

/* The face that is met is the one entered last; it looks against the ray. */
static inline mask meet_box(vector d, lanes *t, vector *normal)
{
    vector enter, leave, local = to_box(d);
    slabs(times(all(-1), to_box(point(BOX_X, BOX_Y, BOX_Z))), local, &enter, &leave);
    lanes in = most(enter.x, most(enter.y, enter.z)), out = least(leave.x, least(leave.y, leave.z));
    mask on_x = at_most(in, enter.x), on_y = at_most(in, enter.y), up = below(local.y, all(0));
    mask right = below(local.x, all(0)), front = below(local.z, all(0));
    vector x = from_box((vector){where(right, all(1), all(-1)), all(0), all(0)});
    vector y = {all(0), where(up, all(1), all(-1)), all(0)};
    vector z = from_box((vector){all(0), all(0), where(front, all(1), all(-1))});
    *normal = vector_where(on_x, x, vector_where(on_y, y, z));
    *t = in;
    return at_most(in, out) & below(all(0), in);
}

static inline hits meet_all(vector d)
{
    hits found;
    lanes t;

    lanes plane_t = PLANE_HEIGHT * inverse(d.y);
    found.plane = below(all(0), plane_t);
    found.t = where(found.plane, plane_t, all(1e30f));

    found.ball = meet_sphere(d, point(BALL_X, BALL_Y, BALL_Z), BALL_RADIUS, &t) & below(t, found.t);
    found.t = where(found.ball, t, found.t);

    found.marble = meet_sphere(d, point(MARBLE_X, MARBLE_Y, MARBLE_Z), MARBLE_RADIUS, &t) & below(t, found.t);
    found.t = where(found.marble, t, found.t);

    found.box = meet_box(d, &t, &found.box_normal) & below(t, found.t);
    found.t = where(found.box, t, found.t);

    found.marble &= not(found.box);
    found.ball &= not(found.box | found.marble);
    found.plane &= not(found.box | found.marble | found.ball);
    return found;
}

static inline vector normal_at(vector p, const hits *found)
{
    vector ball = times(all(1 / BALL_RADIUS), minus(p, point(BALL_X, BALL_Y, BALL_Z)));
    vector marble = times(all(1 / MARBLE_RADIUS), minus(p, point(MARBLE_X, MARBLE_Y, MARBLE_Z)));
    vector normal = vector_where(found->ball, ball, point(0, 1, 0));
    normal = vector_where(found->marble, marble, normal);
    return vector_where(found->box, found->box_normal, normal);
}

static inline vector color_of(const hits *found)
{
    vector color = point(PLANE_COLOR_X, PLANE_COLOR_Y, PLANE_COLOR_Z);
    color = vector_where(found->ball, point(BALL_COLOR_X, BALL_COLOR_Y, BALL_COLOR_Z), color);
    color = vector_where(found->marble, point(MARBLE_COLOR_X, MARBLE_COLOR_Y, MARBLE_COLOR_Z), color);
    return vector_where(found->box, point(BOX_COLOR_X, BOX_COLOR_Y, BOX_COLOR_Z), color);
}

/* --- What stands between the light and points: w leads from the light to them, so they are at t = 1 --------- */

/* Light and point are both outside, so the chord is between them if the middle of it is, at t = b / |w|^2. */
static inline mask sphere_between(vector w, lanes distance_squared, vector centre, float radius)
{
    vector c = minus(centre, point(LIGHT_X, LIGHT_Y, LIGHT_Z));
    lanes b = dot(w, c);
    lanes discriminant = b * b - distance_squared * (dot(c, c) - radius * radius);
    return below(all(0), discriminant) & below(all(0), b) & below(b, distance_squared);
}

static inline mask box_between(vector w)
{
    vector enter, leave;
    slabs(to_box(point(LIGHT_X - BOX_X, LIGHT_Y - BOX_Y, LIGHT_Z - BOX_Z)), to_box(w), &enter, &leave);
    lanes in = most(enter.x, most(enter.y, enter.z)), out = least(leave.x, least(leave.y, leave.z));
    return at_most(in, out) & below(all(0), out) & below(in, all(1));
}

/* The light is above the plane: the plane is between if the point is below. */
static inline mask plane_between(vector w) { return below(w.y, all(PLANE_HEIGHT - LIGHT_Y)); }

static inline mask shadowed(vector w, lanes distance_squared, const hits *found)
{
    mask ball = sphere_between(w, distance_squared, point(BALL_X, BALL_Y, BALL_Z), BALL_RADIUS);
    mask marble = sphere_between(w, distance_squared, point(MARBLE_X, MARBLE_Y, MARBLE_Z), MARBLE_RADIUS);
    return (ball & not(found->ball)) | (marble & not(found->marble)) | (box_between(w) & not(found->box))
        | (plane_between(w) & not(found->plane));
}

/* --- Pixels ------------------------------------------------------------------------------------------------- */

/* 255 sRGB(x) of exposed radiance. With s = sqrt(x) the power 1 / 2.4 is s^(5/6), which a polynomial of degree 5
 * meets to 0.083 of a level between 0.0031308 and 1 (a minimax fit). IEC 61966-2-1. */
static inline lanes develop(lanes x)
{
    x = least(x, all(1));
    lanes s = rough_root(x);
    lanes curve = all(131.911979f) * s + all(-414.031902f);
    curve = curve * s + all(518.050111f);
    curve = curve * s + all(-357.696946f);
    curve = curve * s + all(387.077266f);
    curve = curve * s + all(-10.227938f);
    return where(below(x, all(0.0031308f)), all(255 * 12.92f) * x, curve);
}

/* radiance = color * LIGHT_SCALE * cos / r^2, and cos = n . l / r. */
static inline void render_block(uint8_t *out, vector d, float exposure)
{
    hits found = meet_all(d);
    vector p = times(found.t, d);
    vector w = minus(p, point(LIGHT_X, LIGHT_Y, LIGHT_Z));
    vector normal = normal_at(p, &found);
    lanes facing = -dot(normal, w);
    mask lit = (found.plane | found.ball | found.marble | found.box) & below(all(0), facing);
    if (!any(lit)) {
        memset(out, 0, BYTES_PER_BLOCK);
        return;
    }
    lanes distance_squared = dot(w, w);
    lanes nearness = inverse_root(distance_squared);
    lit &= not(shadowed(w, distance_squared, &found));
    lanes arriving = all(LIGHT_SCALE * exposure) * facing * (nearness * nearness * nearness);
    vector radiance = times(where(lit, arriving, all(0)), color_of(&found));
    store(out, develop(radiance.x), develop(radiance.y), develop(radiance.z));
}

static void render(uint8_t *out, int width, int height, float exposure)
{
    const float scale = TAN_HALF_FOV / (float)height;
    lanes first;
    for (int i = 0; i < LANES; i++)
        first[i] = (float)(2 * i + 1 - width);
    for (int row = 0; row < height; row++) {
        const float y = (float)(height - 2 * row - 1) * scale;
        const vector base = point(FORWARD_X + y * UP_X, FORWARD_Y + y * UP_Y, FORWARD_Z + y * UP_Z);
        for (int column = 0; column < width; column += LANES) {
            lanes x = (first + (float)(2 * column)) * scale;
            vector d = {base.x + x * RIGHT_X, base.y + x * RIGHT_Y, base.z + x * RIGHT_Z};
            render_block(out, times(inverse_root(dot(d, d)), d), exposure);
            out += BYTES_PER_BLOCK;
        }
    }
}

/* --- The clock ---------------------------------------------------------------------------------------------- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int write_ppm(const char *name, const uint8_t *pixels, int width, int height)
{
    const size_t size = (size_t)width * (size_t)height * 3;
    FILE *file = fopen(name, "wb");
    if (file == NULL)
        return 1;
    fprintf(file, "P6\n%d %d\n255\n", width, height);
    const int complete = fwrite(pixels, 1, size, file) == size;
    return fclose(file) != 0 || !complete;
}

int main(int count, char **words)
{
    if (count < 5) {
        fprintf(stderr, "usage: brute_force WIDTH HEIGHT REPETITIONS EXPOSURE [OUT.ppm]\n");
        return 2;
    }
    const int width = atoi(words[1]), height = atoi(words[2]), repetitions = atoi(words[3]);
    if (width < LANES || width % LANES != 0 || height < 1 || repetitions < 1) {
        fprintf(stderr, "brute_force: the width must be a multiple of %d\n", LANES);
        return 2;
    }
    uint8_t *pixels = malloc((size_t)width * (size_t)height * 3);
    double *seconds = malloc((size_t)repetitions * sizeof *seconds);
    if (pixels == NULL || seconds == NULL)
        return 1;
    for (int i = 0; i < repetitions; i++) {
        const double start = now();
        render(pixels, width, height, exp2f((float)atof(words[4])));
        seconds[i] = now() - start;
    }
    if (count > 5 && write_ppm(words[5], pixels, width, height) != 0)
        return 1;
    const double first = seconds[0];
    qsort(seconds, (size_t)repetitions, sizeof *seconds, ascending);
    const double median = seconds[repetitions / 2];
    printf("{\"simd\": \"%s\", \"first\": %.9f, \"trace + develop\": %.9f}\n", SIMD, first, median);
    free(pixels);
    free(seconds);
    return 0;
}
