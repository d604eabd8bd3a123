// SPDX-License-Identifier: Apache-2.0
//
// The cloth of weaveusd from afar in GLSL: what the yarns under a footprint send back, from the
// moments of how they lie. It computes what weaveusd/shading/distance.py does with its nodes LEAN;
// a test compares them. The optics are those of weaveusd_cloth.glsl, which comes first.
//
// Directions are unit vectors away from the surface, `wi` to the viewer and `wo` to the light. The
// cloth's frame has x along the weft, y along the warp and z out of the face; a yarn's frame has x
// across the yarn, y along it and z as the cloth.

#define WEAVEUSD_KINDS 4
#define WEAVEUSD_ARCS 2 // pieces of what rises, and of what falls
#define WEAVEUSD_NOTHING 1e-6 // share of a footprint that is none
#define WEAVEUSD_POINT 1e-4 // least width of a box across the yarn, so that a part of it may be lit
#define WEAVEUSD_STEEPEST 0.9998 // sine of the greatest inclination

// One system of threads: the components of its moment maps, and what its kinds of yarn are like.
struct WeaveusdSystem
{
    vec4 slopes; // shares of straight, rising and falling yarn; place X across
    vec4 along; // places S and S^2 along the float of what rises, then of what falls
    vec4 across; // |X|, X^2, twist P and P^2
    vec3 albedo; // of the fibre, times the share of the system
    vec4 kinds; // shares of the kinds
    vec2 section; // thickness over width, thickness over bend
    mat4 fibre; // a column for each kind: eta, k_d, k_s, tau
    mat4 lobes; // a column for each kind: gamma_s, gamma_v, normalization
};

WeaveusdSystem weaveusd_gathered(vec4 slopes, vec4 along, vec4 across, vec3 albedo, vec4 kinds,
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

// Whether there are maps, and something in them.
bool weaveusd_is_mapped(WeaveusdSystem warp, WeaveusdSystem weft)
{
    return weaveusd_coverage(warp) + weaveusd_coverage(weft) > WEAVEUSD_NOTHING;
}

// How much of the cloth is seen from afar, 0 where a footprint is below one texel of the finest
// maps and 1 from two texels on: `dx` and `dy` are what texture coordinates in such texels change
// by from pixel to pixel. The longer side counts, as it does for the mip maps.
float weaveusd_farness(vec2 dx, vec2 dy)
{
    return clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-12)), 0.0, 1.0);
}

// An even distribution within `low` and `high`, from its share and sums: both ends. The half width
// is sqrt(3 variance).
vec2 weaveusd_box(float share, float first, float second, float low, float high)
{
    float mean = first / max(share, 1e-12);
    float reach = sqrt(3.0 * max(second / max(share, 1e-12) - mean * mean, 0.0));
    return vec2(max(mean - reach, low), min(mean + reach, high));
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

// The bounds in X between which a yarn inclined by u faces `w`, for its outer (1) or inner face.
vec2 weaveusd_lit(vec3 w, float face, vec2 bend, vec2 section)
{
    float c = face * dot(w.yz, bend);
    float aside = face * w.x;
    float border = c / max(length(vec2(c, section.x * aside)), 1e-12);
    return vec2(aside > 0.0 ? -border : -1.0, aside < 0.0 ? border : 1.0);
}

// |n.wo|, negative where yarn and cloth disagree on the side of the light, which is `side`.
float weaveusd_cosine(vec3 wi, vec3 wo, float side, vec3 normal)
{
    return (dot(normal, wi) < 0.0 ? -side : side) * dot(normal, wo);
}

// The mean of max(c, 0) where c runs evenly from `begin` to `end`.
float weaveusd_mean_above(float begin, float end)
{
    float low = min(begin, end);
    float high = max(begin, end);
    float above = max(high, 0.0);
    return low >= 0.0 ? 0.5 * (low + high) : above * above / (2.0 * max(high - low, 1e-12));
}

// The mean of a Cauchy lobe where theta_h runs evenly from `begin` to `end`, and the mean place,
// 0 to 1, of what it holds there; both have closed antiderivatives.
vec2 weaveusd_mean_cauchy(float gamma, float begin, float end)
{
    float width = end - begin;
    if (abs(width) < 1e-3 * gamma)
    {
        return vec2(weaveusd_cauchy(gamma, 0.5 * (begin + end)), 0.5);
    }
    float g2 = gamma * gamma;
    // The difference of two arc tangents, without cancellation.
    float mass = WEAVEUSD_ATAN(gamma * width, g2 + begin * end);
    float mean = 0.5 * gamma * log((end * end + g2) / (begin * begin + g2)) / mass;
    return vec2(mass / (WEAVEUSD_PI * width), clamp((mean - begin) / width, 0.0, 1.0));
}

// What an arc from `s.x` to `s.y` at the place `x` across sends back: by the surface lobe, and by
// the volume lobe for an albedo of 1. The volume lobe has the frame in the middle of the arc, the
// surface lobe that at its mean place.
vec2 weaveusd_strand(vec3 wi, vec3 wo, float side, vec2 s, float x, float sin_psi,
                     WeaveusdSystem yarns)
{
    vec3 normal;
    vec3 fibre;
    weaveusd_frame(s.x, x, sin_psi, yarns.section, normal, fibre);
    float begin = weaveusd_pair(wi, wo, normal, fibre).theta_h;
    float cosine_begin = weaveusd_cosine(wi, wo, side, normal);
    weaveusd_frame(s.y, x, sin_psi, yarns.section, normal, fibre);
    float end = weaveusd_pair(wi, wo, normal, fibre).theta_h;
    float cosine_end = weaveusd_cosine(wi, wo, side, normal);
    weaveusd_frame(0.5 * (s.x + s.y), x, sin_psi, yarns.section, normal, fibre);
    WeaveusdPair pair = weaveusd_pair(wi, wo, normal, fibre);
    float cosine_middle = weaveusd_cosine(wi, wo, side, normal);
    float cosine = 0.5 * (weaveusd_mean_above(cosine_begin, cosine_middle)
                          + weaveusd_mean_above(cosine_middle, cosine_end));
    float center = 0.5 * (0.5 * (begin + end) + pair.theta_h);
    float reach = 0.5 * (end - begin);

    vec2 sent = vec2(0.0);
    for (int k = 0; k < WEAVEUSD_KINDS; ++k)
    {
        float share = yarns.kinds[k];
        if (share <= 0.0)
        {
            continue;
        }
        vec4 optics = yarns.fibre[k];
        vec4 lobes = yarns.lobes[k];
        vec2 narrow = weaveusd_mean_cauchy(lobes.x, center - reach, center + reach);
        float wide = weaveusd_mean_cauchy(lobes.y, center - reach, center + reach).x;
        sent.y += share * lobes.z * cosine
                  * weaveusd_volume(pair, optics.x, optics.y, optics.w, wide, side > 0.0);
        if (side > 0.0)
        {
            weaveusd_frame(mix(s.x, s.y, narrow.y), x, sin_psi, yarns.section, normal, fibre);
            sent.x += share * max(weaveusd_cosine(wi, wo, side, normal), 0.0)
                      * weaveusd_surface(weaveusd_pair(wi, wo, normal, fibre), optics.x, optics.z, narrow.x);
        }
    }
    return sent;
}

// What one system sends back, times its share: by the surface, and by the volume for an albedo of 1.
// Directions are in the yarn's frame.
vec2 weaveusd_system(vec3 wi, vec3 wo, float side, WeaveusdSystem yarns)
{
    float a = weaveusd_coverage(yarns);
    if (a <= WEAVEUSD_NOTHING)
    {
        return vec2(0.0);
    }
    yarns.kinds /= max(dot(yarns.kinds, vec4(1.0)), 1e-12);
    vec4 across = yarns.across / a;
    vec2 aside = weaveusd_box(1.0, across.x, across.y, 0.0, 1.0);
    float reach = max(0.5 * (aside.y - aside.x), 0.5 * WEAVEUSD_POINT);
    aside = 0.5 * (aside.x + aside.y) + vec2(-reach, reach);
    float right = clamp(0.5 * (1.0 + yarns.slopes.w / max(yarns.across.x, 1e-12)), 0.0, 1.0);
    float deviation = sqrt(max(across.w - across.z * across.z, 0.0));
    vec2 rising = weaveusd_box(yarns.slopes.y, yarns.along.x, yarns.along.y, 0.0, 1.0);
    vec2 falling = weaveusd_box(yarns.slopes.z, yarns.along.z, yarns.along.w, -1.0, 0.0);
    float outside = wi.z < 0.0 ? -1.0 : 1.0;

    vec2 sent = vec2(0.0);
    float psi_sign = 1.0; // two points of mean and variance, each at every other frame
    for (int arc = 0; arc <= 2 * WEAVEUSD_ARCS; ++arc)
    {
        bool up = arc <= WEAVEUSD_ARCS;
        vec2 whole = arc == 0 ? vec2(0.0) : (up ? rising : falling);
        float share = arc == 0 ? yarns.slopes.x
                               : (up ? yarns.slopes.y : yarns.slopes.z) / float(WEAVEUSD_ARCS);
        if (share <= WEAVEUSD_NOTHING)
        {
            continue;
        }
        float piece = arc == 0 ? 0.0 : float(up ? arc - 1 : arc - 1 - WEAVEUSD_ARCS);
        float step_s = (whole.y - whole.x) / float(WEAVEUSD_ARCS);
        vec2 s = whole.x + step_s * vec2(piece, piece + 1.0);
        psi_sign = -psi_sign;
        for (int half_side = 0; half_side < 2; ++half_side)
        {
            float part = half_side == 0 ? right : 1.0 - right;
            if (part <= WEAVEUSD_NOTHING)
            {
                continue;
            }
            vec2 x = half_side == 0 ? aside : -aside.yx;
            float turned = half_side == 0 ? psi_sign : -psi_sign;
            float sin_psi = clamp(across.z + deviation * turned, -1.0, 1.0);
            vec2 bend = weaveusd_bend(0.5 * (s.x + s.y), 0.5 * (x.x + x.y), yarns.section);
            for (int back = 0; back < 2; ++back)
            {
                float face = back == 0 ? outside : -outside;
                vec2 seen = weaveusd_lit(wi, face, bend, yarns.section);
                vec2 shone = weaveusd_lit(wo, face * side, bend, yarns.section);
                float low = max(max(seen.x, shone.x), x.x);
                float high = min(min(seen.y, shone.y), x.y);
                if (high > low)
                {
                    float weight = (high - low) * share * part / (x.y - x.x);
                    sent += weight * weaveusd_strand(wi, wo, side, s, 0.5 * (low + high), sin_psi,
                                                     yarns);
                }
            }
        }
    }
    return sent;
}

// The mean of the BSDF times |n.wo| over the yarn under a footprint, in 1/sr. Directions are in the
// cloth's frame.
vec3 weaveusd_from_afar(vec3 wi, vec3 wo, WeaveusdSystem warp, WeaveusdSystem weft)
{
    float side = wi.z * wo.z < 0.0 ? -1.0 : 1.0;
    vec2 of_warp = weaveusd_system(wi, wo, side, warp);
    vec2 of_weft = weaveusd_system(weaveusd_turned(wi), weaveusd_turned(wo), side, weft);
    float a_warp = weaveusd_coverage(warp);
    float a_weft = weaveusd_coverage(weft);
    vec3 sent = vec3(of_warp.x + of_weft.x)
                + clamp(warp.albedo / max(a_warp, 1e-12), 0.0, 1.0) * of_warp.y
                + clamp(weft.albedo / max(a_weft, 1e-12), 0.0, 1.0) * of_weft.y;
    return sent / max(a_warp + a_weft, 1e-12);
}

// The lobe by which an environment sees one system: directional albedos, times the share of the
// system, of surface and volume; half width along the yarns with what they differ in inclination;
// share of the volume lobe that leaves on the other side. `wi` is in the yarn's frame.
vec4 weaveusd_system_around(vec3 wi, WeaveusdSystem yarns)
{
    float a = weaveusd_coverage(yarns);
    if (a <= WEAVEUSD_NOTHING)
    {
        return vec4(0.0);
    }
    yarns.kinds /= max(dot(yarns.kinds, vec4(1.0)), 1e-12);
    vec4 optics = vec4(0.0);
    vec4 lobes = vec4(0.0);
    for (int k = 0; k < WEAVEUSD_KINDS; ++k)
    {
        optics += yarns.kinds[k] * yarns.fibre[k];
        lobes += yarns.kinds[k] * yarns.lobes[k];
    }
    float sin_psi = yarns.across.z / a;
    vec2 sent = vec2(0.0);
    for (int slope = 0; slope < 3; ++slope)
    {
        float share = yarns.slopes[slope];
        if (share > WEAVEUSD_NOTHING)
        {
            float s = slope == 0 ? 0.0 : (slope == 1 ? yarns.along.x : yarns.along.z) / share;
            vec3 normal;
            vec3 fibre;
            weaveusd_frame(s, 0.0, sin_psi, yarns.section, normal, fibre);
            sent += share * weaveusd_directional_albedo(wi, fibre, optics.x, optics.y, optics.z,
                                                        lobes.x, lobes.y, lobes.z);
        }
    }
    float mean = (yarns.along.x + yarns.along.z) / a;
    float variance = max((yarns.along.y + yarns.along.w) / a - mean * mean, 0.0);
    return vec4(sent, lobes.x + sqrt(3.0 * variance), optics.w);
}
