// SPDX-License-Identifier: Apache-2.0
//
// What moments say of the yarns under a footprint, in GLSL: even distributions of their places S
// along the float and X across the yarn, and the frame at a place. It computes what
// weaveusd/shading/footprint.py does.
//
// The cloth's frame has x along the weft, y along the warp and z out of the face; a yarn's frame
// has x across the yarn, y along it and z as the cloth.

#define WEAVEUSD_KINDS 4
#define WEAVEUSD_NOTHING 1e-7 // share of a footprint that is none
#define WEAVEUSD_POINT 1e-4 // least width of a box, so that a part of it may be lit
#define WEAVEUSD_STEEPEST 0.9998 // sine of the greatest inclination
#define WEAVEUSD_ROUNDING 0.02 // of shares and means, by half floats or 8 bits

// One system of threads: the components of its moment maps, and what its kinds of yarn are like.
struct WeaveusdSystem
{
    vec4 slopes; // shares of straight, rising and falling yarn; place X across
    vec4 along; // places S and S^2 along the float of what rises, then of what falls
    vec4 across; // |X|, X^2, twist P and P^2
    vec4 albedo; // of the fibre, times the share of the system; that share
    vec4 kinds; // shares of the kinds
    vec2 section; // thickness over width, thickness over bend
    mat4 fibre; // a column for each kind: eta, k_d, k_s, tau
    mat4 lobes; // a column for each kind: gamma_s, gamma_v, normalization
};

WeaveusdSystem weaveusd_gathered(vec4 slopes, vec4 along, vec4 across, vec4 albedo, vec4 kinds,
                                 vec2 section, mat4 fibre, mat4 lobes)
{
    WeaveusdSystem yarns;
    yarns.slopes = slopes;
    yarns.along = along;
    yarns.across = across;
    yarns.albedo = albedo;
    yarns.kinds = kinds;
    yarns.section = section;
    yarns.fibre = fibre;
    yarns.lobes = lobes;
    return yarns;
}

// A direction of the cloth's frame in the frame of the weft.
vec3 weaveusd_turned(vec3 w)
{
    return vec3(-w.y, w.x, w.z);
}

// Opacity of the system in the footprint.
float weaveusd_coverage(WeaveusdSystem yarns)
{
    return yarns.slopes.x + yarns.slopes.y + yarns.slopes.z;
}

// Whether one slope is such as yarn has: its share, and its means of |S| and S^2.
bool weaveusd_is_slope(float share, float mean, float square)
{
    bool rises = share <= WEAVEUSD_ROUNDING || mean > 0.0;
    return rises && share >= 0.0 && mean >= -WEAVEUSD_ROUNDING && mean <= share + WEAVEUSD_ROUNDING
           && square <= mean + WEAVEUSD_ROUNDING;
}

// Whether the maps of a system are such as yarn has, each of them and all together. An image that
// is not there, or cannot be read, is zeros to one renderer, and to another black, white, gray or
// magenta. Where no map of kinds is connected, all yarn is of the first.
bool weaveusd_is_sound(WeaveusdSystem yarns)
{
    float a = weaveusd_coverage(yarns);
    bool one_kind = yarns.kinds.x == 1.0 && dot(yarns.kinds.yzw, vec3(1.0)) == 0.0;
    bool shares = abs(yarns.albedo.w - a) <= WEAVEUSD_ROUNDING
                  && (one_kind || abs(dot(yarns.kinds, vec4(1.0)) - a) <= WEAVEUSD_ROUNDING);
    bool along = yarns.slopes.x >= 0.0
                 && weaveusd_is_slope(yarns.slopes.y, yarns.along.x, yarns.along.y)
                 && weaveusd_is_slope(yarns.slopes.z, -yarns.along.z, yarns.along.w);
    // Only what is straight, such as a hair, may lie in the middle of the yarn alone. No fibre lies
    // square across its yarn.
    bool straight = yarns.slopes.y + yarns.slopes.z <= WEAVEUSD_ROUNDING;
    bool across = (straight || yarns.across.x > 0.0)
                  && abs(yarns.slopes.w) <= yarns.across.x + WEAVEUSD_ROUNDING
                  && yarns.across.x <= a + WEAVEUSD_ROUNDING
                  && yarns.across.y <= yarns.across.x + WEAVEUSD_ROUNDING
                  && yarns.across.w <= (1.0 - WEAVEUSD_ROUNDING) * a;
    return shares && along && across && yarns.section.x > 0.0 && yarns.section.y >= 0.0;
}

// Whether there are maps, of yarn that does not cover more than all. Else only the yarn is known.
bool weaveusd_is_mapped(WeaveusdSystem warp, WeaveusdSystem weft)
{
    float a = weaveusd_coverage(warp) + weaveusd_coverage(weft);
    return a > WEAVEUSD_NOTHING && a <= 1.0 + WEAVEUSD_ROUNDING && weaveusd_is_sound(warp)
           && weaveusd_is_sound(weft);
}

// How much of the cloth is seen from afar, 0 where a footprint is below half a texel of the finest
// maps and 1 from one texel on: `dx` and `dy` are what texture coordinates in such texels change by
// from pixel to pixel. The longer side counts, as it does for the mip maps.
float weaveusd_farness(vec2 dx, vec2 dy)
{
    return clamp(1.0 + 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-12)), 0.0, 1.0);
}

// The ends of two parts of equal share of what rises, from the means of S and S^2: one box, or two
// that adjoin at the median, the first from 0, where the variance is more than a box can have.
vec3 weaveusd_quantiles(float mean, float square)
{
    mean = max(mean, 0.0);
    float reach = sqrt(3.0 * max(square - mean * mean, 0.0));
    if (reach <= mean)
    {
        return vec3(mean - reach, mean, min(mean + reach, 1.0));
    }
    float middle = max(0.5 * (3.0 * mean - sqrt(max(6.0 * square - 7.0 * mean * mean, 0.0))), 0.0);
    return vec3(0.0, middle, min(4.0 * mean - 2.0 * middle, 1.0));
}

// The even distributions in X of both halves of the yarn: low and high end of the right half and of
// the left. `share` becomes their shares. `across` are the means of |X| and X^2, `mean` is that of
// X.
vec4 weaveusd_halves(vec2 across, float mean, out vec2 share)
{
    float right = max(0.5 * (across.x + mean), 0.0);
    float left = max(0.5 * (across.x - mean), 0.0);
    float apart = clamp(0.5 * (1.0 + mean / max(across.x, 1e-12)), 0.0, 1.0);
    float around = sqrt(right) / max(sqrt(right) + sqrt(left), 1e-12);
    float spread = clamp(3.0 * (across.y / max(across.x * across.x, 1e-24) - 1.0), 0.0, 1.0);
    float part = min(max(mix(apart, around, spread), right), max(1.0 - left, right));
    share = vec2(part, 1.0 - part);
    vec2 kept = step(vec2(WEAVEUSD_NOTHING), share);
    vec2 middle = kept * vec2(right, left) / max(share, vec2(WEAVEUSD_NOTHING));
    float rest = max(across.y - dot(kept * share, middle * middle), 0.0);
    vec2 width = share * sqrt(12.0 * rest / dot(kept, share * share * share));
    width = min(width, min(2.0 * middle, 2.0 - 2.0 * middle));
    vec2 reach = 0.5 * max(width, vec2(WEAVEUSD_POINT));
    return vec4(middle.x - reach.x, middle.x + reach.x, -middle.y - reach.y, -middle.y + reach.y);
}

// sin u and cos u at the place (s, x), for u the inclination of the yarn.
vec2 weaveusd_bend(float s, float x, vec2 section)
{
    float cos_v = sqrt(max(1.0 - x * x, 0.0));
    float sine = s * (1.0 + section.y) / (1.0 + section.y * cos_v);
    sine = clamp(sine, -WEAVEUSD_STEEPEST, WEAVEUSD_STEEPEST);
    return vec2(sine, sqrt(1.0 - sine * sine));
}

// Normal and fibre at the place (s, x), in the yarn's frame.
void weaveusd_frame(float s, float x, float sin_psi, vec2 section, out vec3 normal, out vec3 fibre)
{
    vec2 bend = weaveusd_bend(s, x, section);
    vec2 slope = normalize(vec2(section.x * x, sqrt(max(1.0 - x * x, 0.0))));
    float cos_psi = sqrt(1.0 - sin_psi * sin_psi);
    normal = vec3(slope.x, slope.y * bend.x, slope.y * bend.y);
    fibre = vec3(-sin_psi * slope.y, cos_psi * bend.y + sin_psi * slope.x * bend.x,
                 sin_psi * slope.x * bend.y - cos_psi * bend.x);
}
