"""The programs of the graphics card, in GLSL 3.30.

The light is that of Ogre, with which Gazebo draws: see `model.Material` and `model.Light`.
"""

MAX_LIGHTS = 16
TABLE_WIDTH = 1024          # of the texture of materials, which has three rows for so many

DEPTH_VERTEX = '''
#version 330
uniform mat4 to_clip;
in vec3 position;
void main() {
    gl_Position = to_clip * vec4(position, 1.0);
}
'''

DEPTH_FRAGMENT = '''
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

SKY_VERTEX = '''
#version 330
uniform mat4 to_ray;
uniform float lowest;
in vec2 corner;
noperspective out vec3 ray;
void main() {
    ray = (to_ray * vec4(corner, -1.0, 0.0)).xyz;
    gl_ClipDistance[0] = ray.z + lowest * length(ray);
    gl_Position = vec4(corner, 1.0, 1.0);
}
'''

# The colors of Gazebo's sky at its default time, 10 o'clock, within 8 of 255: how much light comes
# from a direction, by its height and the angle to the sun, and what is left of that in an image.
SKY_FRAGMENT = '''
#version 330
noperspective in vec3 ray;
uniform vec3 background;
out vec4 color;
const vec3 sun = vec3(0.0, 0.6198, 0.7847);
void main() {
    vec3 way = ray * inversesqrt(dot(ray, ray));
    float low = min(1.0 - way.z, 1.23), low4 = low * low * low * low, low8 = low4 * low4;
    float cosine = dot(way, sun), square = cosine * cosine;
    float glow = inversesqrt(1.9801 - 1.98 * cosine);
    vec3 light = vec3(0.235, 0.291, 0.606) + low * vec3(0.367, 0.428, 0.721)
        + low4 * vec3(0.978, 1.22, 2.4) - low8 * vec3(0.258, 0.462, 2.118)
        + low8 * low8 * vec3(-0.069, -0.065, 0.175)
        + square * (vec3(0.103, 0.122, 0.232) + low * vec3(0.261, 0.333, 0.727)
                    + low4 * vec3(0.252, 0.228, -0.206))
        + glow * glow * glow * (1.0 + square) * vec3(0.000122, 0.000119, 0.000102);
    float below = clamp((low - 1.13) * 10.1, 0.0, 1.0);
    color = vec4(mix(1.0 - exp(-light), background, below * (0.55 + 0.45 * below)), 1.0);
}
'''

# What is lit by directions alone, has no highlight and is not bent much, is lit at its corners:
# where OpenGL runs on the processor, what is interpolated and computed for a pixel takes time.
_LIGHT = '''
uniform int light_count;
uniform vec4 place[MAX_LIGHTS];     // of a light; of a directional one, the direction to it, and 0
uniform vec3 lamp[MAX_LIGHTS], lamp_specular[MAX_LIGHTS], axis[MAX_LIGHTS], cone[MAX_LIGHTS];
uniform vec4 fading[MAX_LIGHTS];    // what it is divided by, and how far it reaches

float strength(int i, vec3 to_light, float distance) {
    if (place[i].w == 0.0)
        return 1.0;
    float share = (dot(axis[i], -to_light) - cone[i].x) * cone[i].y;
    float lit = share > 0.0 && distance <= fading[i].w ? pow(min(share, 1.0), cone[i].z) : 0.0;
    return lit / max(dot(fading[i].xyz, vec3(1.0, distance, distance * distance)), 1e-6);
}
'''.replace('MAX_LIGHTS', str(MAX_LIGHTS))

_CORNER_LIGHT = '''
vec3 sent(vec3 base, vec3 diffuse, vec3 normal) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < light_count; i++)
        sum += max(dot(normal, place[i].xyz), 0.0) * lamp[i];
    return base + sum * diffuse;
}
'''

_VERTEX = '''
uniform mat4 to_clip, model;
uniform vec3 eye;
uniform float ceiling;
uniform vec2 kept_heights;      // factor and offset; what is negative then is not drawn
uniform sampler2D materials;
in vec3 position, normal;
in vec2 uv;
in uint material;
out vec2 on_image;
#ifdef PIXELS
out vec3 outward, world;
flat out vec4 base, diffuse, specular;
#else
out vec4 tint;
#endif
#ifdef FOG
uniform vec4 fog;               // end, 1 / (end - start), density, exponent
out float clear;
#endif
vec4 property(int row) {
    int number = int(material);
    return texelFetch(materials, ivec2(number % WIDTH, number / WIDTH * 3 + row), 0);
}
void main() {
    vec4 at = model * vec4(position, 1.0);
    vec3 turned = mat3(model) * normal;
#ifdef PIXELS
    outward = turned;
    world = at.xyz;
    base = property(0);
    diffuse = property(1);
    specular = property(2);
#else
    vec4 sum = property(0);
    tint = vec4(sent(sum.rgb, property(1).rgb, normalize(turned)), sum.a);
#endif
    on_image = uv;
    gl_ClipDistance[0] = kept_heights.x * at.z + kept_heights.y;
    gl_ClipDistance[1] = ceiling - at.z;
    gl_Position = to_clip * at;
#ifdef FOG      // of the corners alone, as in Gazebo
    float depth = abs(gl_Position.w);
    clear = fog.w == 0.0 ? (fog.x - depth) * fog.y : exp(-pow(depth * fog.z, fog.w));
    clear = clamp(clear, 0.0, 1.0);
#endif
}
'''.replace('WIDTH', str(TABLE_WIDTH))

_FRAGMENT = '''
uniform sampler2D image;
uniform vec3 eye;
in vec2 on_image;
#ifdef PIXELS
in vec3 outward, world;
flat in vec4 base, diffuse, specular;
#else
in vec4 tint;
#endif
#ifdef FOG
uniform vec3 fog_color;
in float clear;
#endif
out vec4 color;
void main() {
#ifdef PIXELS
    vec3 facing = normalize(outward), to_eye = normalize(eye - world);
    vec3 sum = vec3(0.0), highlight = vec3(0.0);
    for (int i = 0; i < light_count; i++) {
        vec3 way = place[i].xyz - place[i].w * world;
        float distance = length(way);
        vec3 to_light = way / distance;
        float cosine = dot(facing, to_light);
        if (cosine > 0.0) {
            float share = strength(i, to_light, distance);
            sum += cosine * share * lamp[i];
            float half_cosine = max(dot(facing, normalize(to_light + to_eye)), 0.0);
            highlight += share * pow(half_cosine, diffuse.a) * lamp_specular[i];
        }
    }
    vec4 tint = vec4(base.rgb + sum * diffuse.rgb, base.a);
    highlight *= specular.rgb;
#endif
#ifdef TEXTURED
    color = tint * texture(image, on_image);
#else
    color = tint;
#endif
#ifdef PIXELS
    color.rgb += highlight;
#endif
#ifdef FOG
    color = mix(vec4(fog_color, 1.0), color, clear);      // what is transparent as well
#endif
}
'''


def shaded(*options: str) -> dict:
    """Return the arguments of a program for surfaces.

    options: TEXTURED; PIXELS for light that is computed for each pixel; FOG.
    """
    head = '#version 330\n' + ''.join('#define {}\n'.format(option) for option in options)
    return {'vertex_shader': head + (
                '' if 'PIXELS' in options else _LIGHT + _CORNER_LIGHT) + _VERTEX,
            'fragment_shader': head + (_LIGHT if 'PIXELS' in options else '') + _FRAGMENT}
