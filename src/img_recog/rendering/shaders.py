"""The programs of the graphics card, in GLSL 3.30.

The light is that of PyBullet's window: a face with cosine c between its normal and the sun shows
0.75 + 0.25 c of its color; in shadow or turned away 0.675 + 0.175 c.
"""

SHADOW_DEPTH_M = 400.0      # from the near to the far end of the shadow map
_SHADE = 'mix(0.675 + 0.175 * cosine, 0.75 + 0.25 * cosine, lit)'

SHADOW_VERTEX = '''
#version 330
uniform mat4 to_clip;
in vec3 position;
void main() {
    gl_Position = to_clip * vec4(position, 1.0);
}
'''

SHADOW_FRAGMENT = '''
#version 330
void main() {
}
'''

WHOLE_VERTEX = '''
#version 330
in vec2 corner;
void main() {
    gl_Position = vec4(corner, 0.0, 1.0);
}
'''

COPY_DEPTH_FRAGMENT = '''
#version 330
uniform sampler2D depths;
void main() {
    gl_FragDepth = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
}
'''

CLEAR_FRAGMENT = '''
#version 330
out vec4 color;
void main() {
    color = vec4(0.0);
    gl_FragDepth = 1.0;
}
'''

# twice as fast on a processor as a copy between the framebuffers
RESOLVE_FRAGMENT = '''
#version 330
uniform sampler2DMS samples;
out vec4 color;
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    color = 0.25 * (texelFetch(samples, pixel, 0) + texelFetch(samples, pixel, 1)
                    + texelFetch(samples, pixel, 2) + texelFetch(samples, pixel, 3));
}
'''

# Clipped below the horizon. On a processor, a flat input of a pixel is faster than a uniform: the
# sky takes 0.3 ms instead of 0.5.
SKY_VERTEX = '''
#version 330
uniform mat4 to_ray;
uniform vec3 horizon, zenith;
in vec2 corner;
noperspective out vec3 ray;
flat out vec3 lowest, rise;
void main() {
    ray = (to_ray * vec4(corner, -1.0, 0.0)).xyz;
    lowest = horizon;
    rise = zenith - horizon;
    gl_ClipDistance[0] = ray.z;
    gl_Position = vec4(corner, 1.0, 1.0);
}
'''

SKY_FRAGMENT = '''
#version 330
noperspective in vec3 ray;
flat in vec3 lowest, rise;
out vec4 color;
void main() {
    color = vec4(lowest + rise * (ray.z * inversesqrt(dot(ray, ray))), 1.0);
}
'''

# Of the floor where nothing can shadow it: one color.
LIT_FLOOR_VERTEX = '''
#version 330
uniform mat4 to_clip;
uniform vec3 eye, sun;
in vec3 position;
in vec4 color;
flat out vec4 tint;
void main() {
    float cosine = eye.z > 0.0 ? sun.z : -sun.z;
    float lit = step(0.0, cosine);
    float shade = SHADE;
    tint = vec4(shade, shade, shade, 1.0) * color;
    gl_Position = to_clip * vec4(position, 1.0);
}
'''.replace('SHADE', _SHADE)

FLAT_FRAGMENT = '''
#version 330
flat in vec4 tint;
out vec4 color;
void main() {
    color = tint;
}
'''

# Light is computed for the corners, not for each pixel: where OpenGL runs on the processor, what
# is interpolated and computed for a pixel is what takes time.
SHADED_VERTEX = '''
#version 330
uniform mat4 to_clip, model, to_map;
uniform vec3 eye, sun;
uniform float texel_m, ceiling;
uniform vec2 kept_heights;      // factor and offset; what is negative then is not drawn
in vec3 position, normal;
in vec2 uv;
in vec4 color;
out vec3 on_map;
out float cosine;
out vec2 on_image;
flat out vec4 tint;
void main() {
    vec4 world = model * vec4(position, 1.0);
    vec3 outward = normalize(mat3(model) * normal);
    // a transparent face is seen from both sides, and a file may have normals of the back
    cosine = dot(faceforward(outward, world.xyz - eye, outward), sun);
    on_map = (to_map * world).xyz;
    // a face must not shadow itself where its depth changes within a texel
    on_map.z -= texel_m / DEPTH_M * (1.0 + sqrt(1.0 - cosine * cosine) / max(abs(cosine), 0.1));
    on_image = uv;
    tint = color;
    gl_ClipDistance[0] = kept_heights.x * world.z + kept_heights.y;
    gl_ClipDistance[1] = ceiling - world.z;
    gl_Position = to_clip * world;
}
'''.replace('DEPTH_M', repr(SHADOW_DEPTH_M))

_SHADED_FRAGMENT = '''
#version 330
uniform sampler2D image;
uniform sampler2DShadow shadows;
uniform float grazing;
in vec3 on_map;
in float cosine;
in vec2 on_image;
flat in vec4 tint;
out vec4 color;
void main() {
    float lit = texture(shadows, on_map) * step(grazing, cosine);
    lit = all(equal(on_map, clamp(on_map, 0.0, 1.0))) ? lit : step(grazing, cosine);
    float shade = SHADE;
    color = vec4(shade, shade, shade, 1.0) * tint * TEXEL;
}
'''.replace('SHADE', _SHADE)

PLAIN_FRAGMENT = _SHADED_FRAGMENT.replace('TEXEL', '1.0')
TEXTURED_FRAGMENT = _SHADED_FRAGMENT.replace('TEXEL', 'texture(image, on_image)')
