// SPDX-License-Identifier: Apache-2.0
//
// The cloth of weaveusd from afar in GLSL: what the yarns under a footprint send back. It computes
// what weaveusd/shading/distance.py does with its nodes LEAN, where all that follows is explained;
// a test compares them. The optics are those of weaveusd_cloth.glsl, the yarns those of
// weaveusd_footprint.glsl, which both come first.
//
// Directions are unit vectors away from the surface, `wi` to the viewer and `wo` to the light, in
// the frame of the cloth or of the yarn.

#define WEAVEUSD_MOST_WIDER 2.0 // no strand is lit more than this times as well as its middle

// A direction that the outer (1) or inner face of a yarn is turned to, of which n.w is proportional
// to thickness over width * X * aside + cos v * level * cos(u - phi): aside, level and phi.
vec3 weaveusd_view(vec3 w, float face)
{
    vec2 ahead = face * w.yz;
    return vec3(face * w.x, max(length(ahead), 1e-12), WEAVEUSD_ATAN(ahead.x, ahead.y));
}

// The bounds in X of yarn inclined by the best of `slopes` that faces the view.
vec2 weaveusd_lit_across(vec3 view, vec2 slopes, vec2 section)
{
    float c = view.y * cos(clamp(view.z, slopes.x, slopes.y) - view.z);
    float border = c / max(length(vec2(c, section.x * view.x)), 1e-12);
    return vec2(view.x > 0.0 ? -border : -1.0, view.x < 0.0 ? border : 1.0);
}

// The bounds in S of yarn that faces the view at the place `x` across.
vec2 weaveusd_lit_along(vec3 view, float x, vec2 section)
{
    float cos_v = sqrt(max(1.0 - x * x, 1e-12));
    float c = clamp(-section.x * x * view.x / (cos_v * view.y), -1.0, 1.0);
    float reach = WEAVEUSD_ATAN(sqrt(1.0 - c * c), c);
    vec2 u = clamp(view.z + vec2(-reach, reach), -0.5 * WEAVEUSD_PI, 0.5 * WEAVEUSD_PI);
    return sin(u) * (1.0 + section.y * cos_v) / (1.0 + section.y);
}

// What lies within `box` and both bounds, one place where nothing does.
vec2 weaveusd_inside(vec2 box, vec2 one, vec2 other)
{
    float low = clamp(max(one.x, other.x), box.x, box.y);
    return vec2(low, max(clamp(min(one.y, other.y), box.x, box.y), low));
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

// One frame of an arc: theta_h of both directions, and |n.wo| where the light is on the side of `n`
// that `face` tells, or else 0.
vec2 weaveusd_at(vec3 wi, vec3 wo, float face, vec3 normal, vec3 fibre)
{
    return vec2(weaveusd_pair(wi, wo, normal, fibre).theta_h, max(face * dot(normal, wo), 0.0));
}

// The side of a normal on which light counts: that of the viewer, or the other one where `side` is
// -1.
float weaveusd_face(vec3 wi, float side, vec3 normal)
{
    return dot(normal, wi) < 0.0 ? -side : side;
}

// What an arc `s`, which stands for what lies within `x` across, sends back: by the surface lobe,
// and by the volume lobe for an albedo of 1. The volume lobe has the frame in the middle of the
// arc, the surface lobe that at its mean place.
vec2 weaveusd_strand(vec3 wi, vec3 wo, float side, vec2 s, vec2 x, float sin_psi,
                     WeaveusdSystem yarns)
{
    vec2 section = yarns.section;
    float middle_s = 0.5 * (s.x + s.y);
    float middle_x = 0.5 * (x.x + x.y);
    float aside = 0.28867513 * (x.y - x.x); // a deviation off the middle
    vec3 normal;
    vec3 fibre;
    weaveusd_frame(middle_s, middle_x - aside, sin_psi, section, normal, fibre);
    vec2 left = weaveusd_at(wi, wo, weaveusd_face(wi, side, normal), normal, fibre);
    weaveusd_frame(middle_s, middle_x + aside, sin_psi, section, normal, fibre);
    vec2 right = weaveusd_at(wi, wo, weaveusd_face(wi, side, normal), normal, fibre);
    weaveusd_frame(middle_s, middle_x, sin_psi, section, normal, fibre);
    WeaveusdPair pair = weaveusd_pair(wi, wo, normal, fibre);
    // Both ends may lie where the viewer sees the yarn edge on: they face as the middle does.
    float face = weaveusd_face(wi, side, normal);
    float cosine = max(face * dot(normal, wo), 0.0);
    weaveusd_frame(s.x, middle_x, sin_psi, section, normal, fibre);
    vec2 begin = weaveusd_at(wi, wo, face, normal, fibre);
    weaveusd_frame(s.y, middle_x, sin_psi, section, normal, fibre);
    vec2 end = weaveusd_at(wi, wo, face, normal, fibre);
    // How much more light the strand's width has than its middle.
    float wider = min(0.5 * (left.y + right.y) / max(cosine, 1e-9), WEAVEUSD_MOST_WIDER);
    cosine = wider * (begin.y + 4.0 * cosine + end.y) / 6.0;

    float center = 0.5 * (0.5 * (begin.x + end.x) + pair.theta_h);
    float reach = 0.5 * (end.x - begin.x);
    float apart = right.x - left.x;
    float reached = sqrt(reach * reach + 0.75 * apart * apart);
    reach = reach < 0.0 ? -reached : reached;

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
            weaveusd_frame(mix(s.x, s.y, narrow.y), middle_x, sin_psi, section, normal, fibre);
            sent.x += share * wider * max(face * dot(normal, wo), 0.0)
                      * weaveusd_surface(weaveusd_pair(wi, wo, normal, fibre), optics.x, optics.z,
                                         narrow.x);
        }
    }
    return sent;
}

// What an arc and a half of the yarn send back, of which only that part counts which both viewer
// and light see.
vec2 weaveusd_patch(vec3 wi, vec3 wo, float side, vec3 to_viewer, vec3 to_light, vec2 arc, vec2 x,
                    float sin_psi, WeaveusdSystem yarns)
{
    vec2 section = yarns.section;
    arc = 0.5 * (arc.x + arc.y) + 0.5 * vec2(-1.0, 1.0) * max(arc.y - arc.x, WEAVEUSD_POINT);
    vec2 low = weaveusd_bend(arc.x, 0.5 * (x.x + x.y), section);
    vec2 high = weaveusd_bend(arc.y, 0.5 * (x.x + x.y), section);
    vec2 slopes = vec2(WEAVEUSD_ATAN(low.x, low.y), WEAVEUSD_ATAN(high.x, high.y));
    vec2 across = weaveusd_inside(x, weaveusd_lit_across(to_viewer, slopes, section),
                                  weaveusd_lit_across(to_light, slopes, section));
    float middle = 0.5 * (across.x + across.y);
    vec2 along = weaveusd_inside(arc, weaveusd_lit_along(to_viewer, middle, section),
                                 weaveusd_lit_along(to_light, middle, section));
    float lit = (across.y - across.x) * (along.y - along.x);
    if (lit <= 0.0)
    {
        return vec2(0.0);
    }
    return lit / ((arc.y - arc.x) * (x.y - x.x))
           * weaveusd_strand(wi, wo, side, along, across, sin_psi, yarns);
}

// What one system sends back, times its share: by the surface, and by the volume for an albedo of
// 1. Directions are in the yarn's frame.
vec2 weaveusd_system(vec3 wi, vec3 wo, float side, WeaveusdSystem yarns)
{
    float a = weaveusd_coverage(yarns);
    if (a <= WEAVEUSD_NOTHING)
    {
        return vec2(0.0);
    }
    yarns.kinds /= max(dot(yarns.kinds, vec4(1.0)), 1e-12);
    vec4 across = yarns.across / a;
    vec2 parts;
    vec4 halves = weaveusd_halves(across.xy, yarns.slopes.w / a, parts);
    float deviation = sqrt(max(across.w - across.z * across.z, 0.0));
    vec4 along = yarns.along / max(yarns.slopes.yyzz, vec4(1e-12));
    vec3 rising = weaveusd_quantiles(along.x, along.y);
    vec3 falling = -weaveusd_quantiles(-along.z, along.w);
    float outside = wi.z < 0.0 ? -1.0 : 1.0;
    vec3 to_viewer = weaveusd_view(wi, outside);
    vec3 to_light = weaveusd_view(wo, outside * side);

    vec2 sent = vec2(0.0);
    for (int i = 0; i < 5; ++i)
    {
        vec2 arc = i == 0 ? vec2(0.0)
                          : (i == 1 ? rising.xy
                                    : (i == 2 ? rising.yz : (i == 3 ? falling.yx : falling.zy)));
        float share = i == 0 ? yarns.slopes.x : 0.5 * (i < 3 ? yarns.slopes.y : yarns.slopes.z);
        if (share <= WEAVEUSD_NOTHING)
        {
            continue;
        }
        for (int j = 0; j < 2; ++j)
        {
            float part = j == 0 ? parts.x : parts.y;
            if (part > WEAVEUSD_NOTHING)
            {
                // Two points of mean and variance, each at every other strand.
                float psi = across.z + ((i + j) % 2 == 0 ? -deviation : deviation);
                sent += share * part
                        * weaveusd_patch(wi, wo, side, to_viewer, to_light, arc,
                                         j == 0 ? halves.xy : halves.zw, clamp(psi, -1.0, 1.0),
                                         yarns);
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
                + clamp(warp.albedo.rgb / max(a_warp, 1e-12), 0.0, 1.0) * of_warp.y
                + clamp(weft.albedo.rgb / max(a_weft, 1e-12), 0.0, 1.0) * of_weft.y;
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
