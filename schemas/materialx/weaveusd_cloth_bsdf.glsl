// SPDX-License-Identifier: Apache-2.0
//
// The closure of the node `weaveusd_cloth` for MaterialX's hardware targets. Near by it is the BSDF
// of the yarn that is seen, from afar that of all yarns under the footprint; in between both are
// mixed, and only there both are computed. Lights are exact; an environment is seen through its
// irradiance and through GGX lobes as wide as the surface lobes, both scaled to the directional
// albedos of the cloth.

#include "libraries/pbrlib/genglsl/lib/mx_closure_type.glsl"
#include "libraries/pbrlib/genglsl/lib/mx_microfacet_specular.glsl"
#define WEAVEUSD_ATAN(y, x) mx_atan(y, x)
#include "weaveusd_cloth.glsl"
#include "weaveusd_footprint.glsl"
#include "weaveusd_distance.glsl"

// What the surface lobe shows of an environment, for a directional albedo of 1: a GGX lobe with the
// half width `gamma` along `t`.
vec3 weaveusd_mirrored(vec3 V, vec3 n, vec3 t, float gamma)
{
    vec2 alpha = clamp(vec2(1.4 * tan(min(gamma, 1.0)), 0.8), 0.001, 1.0);
    FresnelData fd = mx_init_fresnel_schlick(vec3(1.0), vec3(1.0), vec3(1.0), 5.0, 0.0, 1.0);
    float cosine = clamp(dot(n, V), M_FLOAT_EPS, 1.0);
    float lost = mx_ggx_dir_albedo(cosine, mx_average_alpha(alpha), 1.0, 1.0);
    return mx_environment_radiance(n, V, t, alpha, 0, fd) / max(lost, 0.01);
}

// What the volume lobe shows of it.
vec3 weaveusd_scattered(vec3 n, float tau)
{
    return (1.0 - tau) * mx_environment_irradiance(n) + tau * mx_environment_irradiance(-n);
}

// What the yarn sends back that is seen, and its directional albedo. `fibre` is eta, k_d, k_s and
// tau, `lobes` is gamma_s, gamma_v and the normalization.
void weaveusd_near(ClosureData closureData, vec3 normal, vec3 tangent, vec3 albedo, vec4 fibre,
                   vec3 lobes, inout vec3 sent, inout vec3 reflected)
{
    vec3 V = closureData.V;
    vec3 L = closureData.L;
    vec3 n = mx_forward_facing_normal(normalize(normal), V);
    vec3 t = normalize(tangent - dot(tangent, n) * n);
    vec2 share = weaveusd_directional_albedo(V, t, fibre.x, fibre.y, fibre.z, lobes.x, lobes.y,
                                             lobes.z);
    reflected = vec3(share.x) + albedo * share.y;
    if (closureData.closureType == CLOSURE_TYPE_REFLECTION)
    {
        if (weaveusd_allowed(V, L, n, closureData.N))
        {
            sent = weaveusd_cloth(V, L, n, t, albedo, fibre.x, fibre.y, fibre.z, lobes.x, lobes.y,
                                  fibre.w, lobes.z)
                   * closureData.occlusion;
        }
    }
    else if (closureData.closureType == CLOSURE_TYPE_INDIRECT)
    {
        sent = share.x * weaveusd_mirrored(V, n, t, lobes.x)
               + albedo * share.y * weaveusd_scattered(n, fibre.w);
    }
}

// What all yarns under the footprint send back, and their directional albedo. The columns of
// `cloth` are the cloth's frame.
void weaveusd_far(ClosureData closureData, mat3 cloth, WeaveusdSystem warp, WeaveusdSystem weft,
                  inout vec3 sent, inout vec3 reflected)
{
    vec3 V = closureData.V;
    vec3 wi = vec3(dot(V, cloth[0]), dot(V, cloth[1]), dot(V, cloth[2]));
    float whole = weaveusd_coverage(warp) + weaveusd_coverage(weft);
    vec3 albedo_warp = warp.albedo.rgb / max(weaveusd_coverage(warp), 1e-12);
    vec3 albedo_weft = weft.albedo.rgb / max(weaveusd_coverage(weft), 1e-12);
    vec4 around_warp = weaveusd_system_around(wi, warp);
    vec4 around_weft = weaveusd_system_around(weaveusd_turned(wi), weft);
    vec3 volume_warp = albedo_warp * around_warp.y / whole;
    vec3 volume_weft = albedo_weft * around_weft.y / whole;
    reflected = vec3(around_warp.x + around_weft.x) / whole + volume_warp + volume_weft;
    if (closureData.closureType == CLOSURE_TYPE_REFLECTION)
    {
        vec3 L = closureData.L;
        vec3 wo = vec3(dot(L, cloth[0]), dot(L, cloth[1]), dot(L, cloth[2]));
        sent = weaveusd_from_afar(wi, wo, warp, weft) * closureData.occlusion;
    }
    else if (closureData.closureType == CLOSURE_TYPE_INDIRECT)
    {
        vec3 n = mx_forward_facing_normal(cloth[2], V);
        sent = around_warp.x / whole * weaveusd_mirrored(V, n, cloth[1], around_warp.z)
               + around_weft.x / whole * weaveusd_mirrored(V, n, cloth[0], around_weft.z)
               + volume_warp * weaveusd_scattered(n, around_warp.w)
               + volume_weft * weaveusd_scattered(n, around_weft.w);
    }
}

void mx_weaveusd_cloth(ClosureData closureData, float weight, vec3 base_color, float eta, float k_d,
                       float k_s, float gamma_s, float gamma_v, float tau, float normalization,
                       float albedo_gain, vec3 normal, vec3 tangent, vec3 surface_normal,
                       vec3 surface_tangent, vec3 surface_bitangent, vec2 moment_texels,
                       vec4 warp_slopes, vec4 warp_along, vec4 warp_across, vec4 warp_albedo,
                       vec4 warp_kinds, vec2 warp_section, mat4 warp_fibres, mat4 warp_lobes,
                       vec4 weft_slopes, vec4 weft_along, vec4 weft_across, vec4 weft_albedo,
                       vec4 weft_kinds, vec2 weft_section, mat4 weft_fibres, mat4 weft_lobes,
                       inout BSDF bsdf)
{
    bsdf.response = vec3(0.0);
    bsdf.throughput = vec3(1.0);
    float farness = weaveusd_farness(dFdx(moment_texels), dFdy(moment_texels));
    if (weight < M_FLOAT_EPS)
    {
        return;
    }
    WeaveusdSystem warp = weaveusd_gathered(warp_slopes, warp_along, warp_across, warp_albedo,
                                            warp_kinds, warp_section, warp_fibres, warp_lobes);
    WeaveusdSystem weft = weaveusd_gathered(weft_slopes, weft_along, weft_across, weft_albedo,
                                            weft_kinds, weft_section, weft_fibres, weft_lobes);
    if (farness > 0.0 && !weaveusd_is_mapped(warp, weft))
    {
        farness = 0.0;
    }
    vec3 sent_near = vec3(0.0);
    vec3 sent_far = vec3(0.0);
    vec3 reflected_near = vec3(0.0);
    vec3 reflected_far = vec3(0.0);
    if (farness < 1.0)
    {
        weaveusd_near(closureData, normal, tangent, weaveusd_albedo(base_color, albedo_gain),
                      vec4(eta, k_d, k_s, tau), vec3(gamma_s, gamma_v, normalization), sent_near,
                      reflected_near);
    }
    if (farness > 0.0)
    {
        vec3 z = normalize(surface_normal);
        vec3 x = normalize(surface_tangent - dot(surface_tangent, z) * z);
        vec3 y = cross(z, x);
        mat3 cloth = mat3(x, dot(y, surface_bitangent) < 0.0 ? -y : y, z);
        weaveusd_far(closureData, cloth, warp, weft, sent_far, reflected_far);
    }
    vec3 reflected = mix(reflected_near, reflected_far, farness);
    bsdf.throughput = vec3(1.0 - weight * dot(reflected, vec3(1.0 / 3.0)));
    bsdf.response = mix(sent_near, sent_far, farness) * weight;
}
