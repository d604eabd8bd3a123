// SPDX-License-Identifier: Apache-2.0
//
// The closure of the node `weaveusd_cloth` for MaterialX's hardware targets. Lights are exact; an
// environment is seen through its irradiance and through a GGX lobe as wide as the surface lobe,
// both scaled to the directional albedos of the cloth.

#include "libraries/pbrlib/genglsl/lib/mx_closure_type.glsl"
#include "libraries/pbrlib/genglsl/lib/mx_microfacet_specular.glsl"
#define WEAVEUSD_ATAN(y, x) mx_atan(y, x)
#include "weaveusd_cloth.glsl"

void mx_weaveusd_cloth(ClosureData closureData, float weight, vec3 base_color, float eta, float k_d,
                       float k_s, float gamma_s, float gamma_v, float tau, float normalization,
                       float albedo_gain, vec3 normal, vec3 tangent, inout BSDF bsdf)
{
    bsdf.response = vec3(0.0);
    bsdf.throughput = vec3(1.0);
    if (weight < M_FLOAT_EPS)
    {
        return;
    }
    vec3 V = closureData.V;
    vec3 L = closureData.L;
    vec3 n = mx_forward_facing_normal(normalize(normal), V);
    vec3 t = normalize(tangent - dot(tangent, n) * n);
    vec3 albedo = weaveusd_albedo(base_color, albedo_gain);
    vec2 share = weaveusd_directional_albedo(V, t, eta, k_d, k_s, gamma_s, gamma_v,
                                             normalization);
    vec3 reflected = vec3(share.x) + albedo * share.y;
    bsdf.throughput = vec3(1.0 - weight * dot(reflected, vec3(1.0 / 3.0)));

    if (closureData.closureType == CLOSURE_TYPE_REFLECTION)
    {
        if (weaveusd_allowed(V, L, n, closureData.N))
        {
            bsdf.response = weaveusd_cloth(V, L, n, t, albedo, eta, k_d, k_s, gamma_s, gamma_v,
                                           tau, normalization)
                            * (closureData.occlusion * weight);
        }
    }
    else if (closureData.closureType == CLOSURE_TYPE_INDIRECT)
    {
        vec2 alpha = clamp(vec2(1.4 * tan(gamma_s), 0.8), 0.001, 1.0);
        FresnelData fd = mx_init_fresnel_schlick(vec3(1.0), vec3(1.0), vec3(1.0), 5.0, 0.0, 1.0);
        float cosine = clamp(dot(n, V), M_FLOAT_EPS, 1.0);
        float lost = mx_ggx_dir_albedo(cosine, mx_average_alpha(alpha), 1.0, 1.0);
        vec3 mirror = mx_environment_radiance(n, V, t, alpha, 0, fd) / max(lost, 0.01);
        vec3 around = (1.0 - tau) * mx_environment_irradiance(n)
                      + tau * mx_environment_irradiance(-n);
        bsdf.response = (share.x * mirror + albedo * share.y * around) * weight;
    }
}
