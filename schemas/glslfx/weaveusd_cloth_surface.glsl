// SPDX-License-Identifier: Apache-2.0
//
// The cloth in Storm, OpenUSD 26.11: every light by the BSDF of weaveusd_cloth.glsl, a dome by its
// irradiance and the cloth's directional albedos. Everything is in eye space.

vec3 weaveusd_from_light(int index, vec4 Peye, vec3 surface, vec3 n, vec3 t, vec3 albedo,
                         vec4 first, vec4 second)
{
    vec3 shown = vec3(0.0);
#if NUM_LIGHTS > 0
    vec3 V = normalize(-Peye.xyz);
    LightSource light = GetLightSource(index);
    if (light.isIndirectLight)
    {
        vec2 share = weaveusd_directional_albedo(V, t, first.x, first.y, first.z, first.w,
                                                 second.x, second.z);
        vec3 around = vec3(1.0);
#ifdef HD_HAS_domeLightIrradiance
        vec4 world = vec4(light.worldToLightTransform * GetWorldToViewInverseMatrix()
                          * vec4(n, 0.0));
        around = HdGet_domeLightIrradiance(normalize(world.xyz)).rgb;
#endif
        return (vec3(share.x) + albedo * share.y) * around * light.diffuse.rgb;
    }
    vec3 L = light.position.w == 0.0 ? normalize(light.position.xyz)
                                     : normalize((light.position - Peye).xyz);
    float intensity = lightDistanceAttenuation(Peye, index) * lightSpotAttenuation(L, index);
#if USE_SHADOWS
    intensity *= light.hasShadow ? shadowing(index, Peye) : 1.0;
#endif
    if (weaveusd_allowed(V, L, n, surface))
    {
        shown = weaveusd_cloth(V, L, n, t, albedo, first.x, first.y, first.z, first.w, second.x,
                               second.y, second.z)
                * light.diffuse.rgb * intensity;
    }
#endif
    return shown;
}

vec4 surfaceShader(vec4 Peye, vec3 Neye, vec4 color, vec4 patchCoord)
{
    float opacity = float(HdGet_opacity());
    if (opacity < 0.5)
    {
        discard;
    }
    // Storm turns Neye to the viewer: the back shows the yarns of the face.
    vec3 surface = normalize(Neye);
    mat3 frame = ComputeTBNMatrix(Peye.xyz, surface, vec2(HdGet_st()));
    vec3 n = normalize(frame * vec3(HdGet_normal()));
    vec3 t = frame * vec3(HdGet_fibre());
    t = normalize(t - dot(t, n) * n);

    int yarn = int(255.0 * float(HdGet_yarn_id()) + 0.5);
    vec4 first = weaveusd_first_optics(yarn);
    vec4 second = weaveusd_second_optics(yarn);
    vec3 albedo = weaveusd_albedo(vec3(HdGet_base_color()), second.w);

    vec3 shown = vec3(0.0);
#if NUM_LIGHTS > 0
    for (int i = 0; i < int(GetLightCount()); ++i)
    {
        shown += weaveusd_from_light(i, Peye, surface, n, t, albedo, first, second);
    }
#endif
    return vec4(shown, 1.0);
}
