// SPDX-License-Identifier: Apache-2.0
//
// The cloth of weaveusd in GLSL: the microcylinder of Sadeghi et al. 2013 with Cauchy lobes,
// normalized. It computes what weaveusd/shading/microcylinder.py does; a test compares them.
//
// Directions are unit vectors away from the surface, `wi` to the viewer and `wo` to the light; `n`
// is the yarn's normal, `t` the fibre's direction, unit and orthogonal. A yarn has two faces: `n`
// is turned to the side of `wi`. Angles are in radians. Only square roots and arc tangents are
// used, which every GLSL computes well; its arc sines and cosines are rough.

#define WEAVEUSD_PI 3.14159265358979
#define WEAVEUSD_SURFACE_SCALE 0.53033008589 // 3 / (4 sqrt(2))
#ifndef WEAVEUSD_ATAN // of y over x, where a language spells it otherwise
#define WEAVEUSD_ATAN(y, x) atan(y, x)
#endif

// Unpolarized reflectance of a dielectric from outside.
float weaveusd_fresnel(float cosine, float eta)
{
    float c = clamp(abs(cosine), 0.0, 1.0);
    float g = sqrt(1.0 - (1.0 - c * c) / (eta * eta));
    float parallel = (eta * c - g) / max(eta * c + g, 1e-7);
    float perpendicular = (c - eta * g) / max(c + eta * g, 1e-7);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

float weaveusd_cauchy(float gamma, float x)
{
    return gamma / (WEAVEUSD_PI * (x * x + gamma * gamma));
}

// Albedo of the fibre: the color of the cloth times the gain of the yarn, never above 1.
vec3 weaveusd_albedo(vec3 base_color, float albedo_gain)
{
    return clamp(base_color * albedo_gain, vec3(0.0), vec3(1.0));
}

// Two directions at a fibre: cosines of their inclinations theta and of half the differences of
// inclinations and azimuths phi. Only sum and difference of the angles matter.
struct WeaveusdPair
{
    float cos_i;
    float cos_o;
    float cos_d;
    float cos_half;
    float theta_h;
};

WeaveusdPair weaveusd_pair(vec3 wi, vec3 wo, vec3 n, vec3 t)
{
    vec3 side = cross(n, t);
    vec2 flat_i = vec2(dot(wi, n), dot(wi, side));
    vec2 flat_o = vec2(dot(wo, n), dot(wo, side));
    float sin_i = dot(wi, t);
    float sin_o = dot(wo, t);
    WeaveusdPair pair;
    pair.cos_i = length(flat_i);
    pair.cos_o = length(flat_o);
    float both = pair.cos_i * pair.cos_o;
    pair.theta_h = 0.5 * WEAVEUSD_ATAN(sin_i * pair.cos_o + sin_o * pair.cos_i,
                                       both - sin_i * sin_o);
    pair.cos_d = sqrt(clamp(0.5 + 0.5 * (both + sin_i * sin_o), 0.0, 1.0));
    float cos_phi = clamp(dot(flat_i, flat_o) / max(both, 1e-12), -1.0, 1.0);
    pair.cos_half = sqrt(0.5 + 0.5 * cos_phi);
    return pair;
}

// The part of a lobe along the fibre, from its profile in theta_h.
float weaveusd_spread(WeaveusdPair pair, float profile)
{
    float m = max(max(pair.cos_i, pair.cos_o), 1e-6);
    return 0.5 * profile / (m * m);
}

// f_R, on the side of the viewer.
float weaveusd_surface(WeaveusdPair pair, float eta, float k_s, float profile)
{
    return k_s * WEAVEUSD_SURFACE_SCALE * weaveusd_fresnel(pair.cos_d * pair.cos_half, eta)
           * pair.cos_half * weaveusd_spread(pair, profile);
}

// f_V, on the side of the viewer where `same`.
float weaveusd_volume(WeaveusdPair pair, float eta, float k_d, float tau, float profile, bool same)
{
    float through = (1.0 - weaveusd_fresnel(pair.cos_i, eta))
                    * (1.0 - weaveusd_fresnel(pair.cos_o, eta));
    float scatter = (1.0 - k_d) * weaveusd_spread(pair, profile)
                    + 0.5 * k_d / max(pair.cos_i + pair.cos_o, 1e-6);
    return (same ? 1.0 - tau : tau) * 0.5 * through * scatter;
}

// f_R |n.wo| and N_V f_V |n.wo|, in 1/sr.
vec2 weaveusd_lobes(vec3 wi, vec3 wo, vec3 n, vec3 t, float eta, float k_d, float k_s,
                    float gamma_s, float gamma_v, float tau, float normalization)
{
    float cos_n = dot(n, wi) < 0.0 ? -dot(n, wo) : dot(n, wo);
    bool same = cos_n > 0.0;
    WeaveusdPair pair = weaveusd_pair(wi, wo, n, t);
    float f_r = weaveusd_surface(pair, eta, k_s, weaveusd_cauchy(gamma_s, pair.theta_h));
    float f_v = weaveusd_volume(pair, eta, k_d, tau, weaveusd_cauchy(gamma_v, pair.theta_h), same);
    return vec2(same ? f_r : 0.0, normalization * f_v) * abs(cos_n);
}

// The BSDF times |n.wo|, in 1/sr; `albedo` is that of the fibre.
vec3 weaveusd_cloth(vec3 wi, vec3 wo, vec3 n, vec3 t, vec3 albedo, float eta, float k_d,
                    float k_s, float gamma_s, float gamma_v, float tau, float normalization)
{
    vec2 f = weaveusd_lobes(wi, wo, n, t, eta, k_d, k_s, gamma_s, gamma_v, tau, normalization);
    return vec3(f.x) + albedo * f.y;
}

// Whether yarn and surface agree on the side of both directions: light may not pass through a yarn
// that is only tilted. `surface` is the normal of the surface, `n` that of the yarn.
bool weaveusd_allowed(vec3 wi, vec3 wo, vec3 n, vec3 surface)
{
    return dot(n, wi) * dot(n, wo) * dot(surface, wi) * dot(surface, wo) > 0.0;
}

// Directional albedos seen from `wi`: of the surface lobe, and of the volume lobe on both sides for
// an albedo of 1, with N_V. The inclinations divide the mass of each lobe evenly, as sampling does
// (Wang et al. 2014); off by 0.02 at most.
vec2 weaveusd_directional_albedo(vec3 wi, vec3 t, float eta, float k_d, float k_s, float gamma_s,
                                 float gamma_v, float normalization)
{
    int inclinations = 8;
    int azimuths = 4;
    float sin_i = clamp(dot(wi, t), -1.0, 1.0);
    float cos_i = sqrt(1.0 - sin_i * sin_i);
    float theta_i = WEAVEUSD_ATAN(sin_i, cos_i);
    vec2 gamma = vec2(gamma_s, gamma_v);
    vec2 low = vec2(WEAVEUSD_ATAN(0.5 * theta_i - 0.25 * WEAVEUSD_PI, gamma_s),
                    WEAVEUSD_ATAN(0.5 * theta_i - 0.25 * WEAVEUSD_PI, gamma_v));
    vec2 high = vec2(WEAVEUSD_ATAN(0.5 * theta_i + 0.25 * WEAVEUSD_PI, gamma_s),
                     WEAVEUSD_ATAN(0.5 * theta_i + 0.25 * WEAVEUSD_PI, gamma_v));
    vec2 step_u = (high - low) / float(inclinations);
    float enter = 1.0 - weaveusd_fresnel(cos_i, eta);
    float surface = 0.0;
    float volume = 0.0;
    for (int i = 0; i < inclinations; ++i)
    {
        vec2 theta_o = 2.0 * gamma * tan(low + (float(i) + 0.5) * step_u) - vec2(theta_i);
        vec2 cos_o = cos(theta_o);
        vec2 ratio = cos_o / max(vec2(cos_i), cos_o);
        float cos_d = cos(0.5 * (theta_i - theta_o.x));
        for (int j = 0; j < azimuths; ++j)
        {
            float sin_phi = (2.0 * float(j) + 1.0) / float(azimuths) - 1.0;
            float cos_half = sqrt(0.5 + 0.5 * sqrt(1.0 - sin_phi * sin_phi));
            surface += weaveusd_fresnel(cos_d * cos_half, eta) * cos_half * ratio.x * ratio.x
                       * step_u.x * 2.0 / (float(azimuths) * WEAVEUSD_PI);
        }
        float leave = 1.0 - weaveusd_fresnel(cos_o.y, eta);
        volume += (1.0 - k_d) * leave * ratio.y * ratio.y * step_u.y / WEAVEUSD_PI;

        float even = ((float(i) + 0.5) / float(inclinations) - 0.5) * WEAVEUSD_PI;
        float cos_e = cos(even);
        volume += k_d * 0.5 * (1.0 - weaveusd_fresnel(cos_e, eta)) * cos_e * cos_e
                  / (cos_i + cos_e) * WEAVEUSD_PI / float(inclinations);
    }
    return vec2(k_s * WEAVEUSD_SURFACE_SCALE * surface, normalization * enter * volume);
}
