/*
 * Motion, cut-outs, relief and textured light from C: everything OUT.pfm renders the scene of everything.toml to the file, and writes the
 * pictures that it names to the working folder. Each part of it can be left out, which has to be seen. Programs that were built
 * before these fields were there still run.
 */

#include "check.h"
#include <math.h>
#include <stddef.h>

enum { WIDTH = 24, HEIGHT = 16, SPP = 4 };

/* What can be left out. */
enum part {
    NOTHING,
    CAMERA_MOTION,
    SHUTTER,
    SHAPE_MOTION,
    INSTANCE_MOTION,
    MASK,
    ALPHA,
    NORMALS,
    BUMPS,
    BUMP_HEIGHT,
    CLEAR_COAT,
    COAT_ROUGHNESS,
    COAT_IOR,
    NORMAL_STRENGTH,
    GLOSS,
    GLOW,
    TURN,
    PARTS
};

/* A small picture, and the file that a scene file would name. */
struct picture {
    const char *file;
    uint32_t width, height;
    float rgb[12][3];
};

static const struct picture bumps = {
    "bumps.pfm",
    2,
    2,
    {{0.7f, 0.5f, 0.9f}, {0.3f, 0.5f, 0.9f}, {0.5f, 0.8f, 0.8f}, {0.5f, 0.5f, 1.0f}}};
static const struct picture mask = {
    "mask.pfm", 3, 1, {{1, 1, 1}, {0, 0, 0}, {2, 2, 2}}};
static const struct picture gloss = {
    "gloss.pfm", 1, 2, {{0.6f, 0.1f, 0.1f}, {0.1f, 0.1f, 0.6f}}};
static const struct picture glow = {
    "glow.pfm", 2, 1, {{1, 0.5f, 0.25f}, {0, 0.25f, 1}}};
static const struct picture sky = {
    "sky.pfm",
    4,
    2,
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {0.25f, 0.25f, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0.5f, 0}}};

static void write_picture(const struct picture *picture) {
    FILE *file = fopen(picture->file, "wb");
    CHECK(file != NULL);
    fprintf(file, "PF\n%u %u\n-1.0\n", picture->width, picture->height);
    /* The lowest row first. */
    for (uint32_t y = picture->height; y-- > 0;) {
        const float *row = picture->rgb[y * picture->width];
        CHECK(fwrite(row, 3 * sizeof *row, picture->width, file) == picture->width);
    }
    CHECK(fclose(file) == 0);
}

static EtdImage image_of(const struct picture *picture, float scale) {
    EtdImage image;
    memset(&image, 0, sizeof image);
    image.struct_size = sizeof image;
    image.width = picture->width;
    image.height = picture->height;
    image.rgb = picture->rgb[0];
    image.scale = scale;
    return image;
}

static const double times[2] = {0, 0.5};
static const EtdCameraKey camera_keys[2] = {
    {0, {0, 1.5, 5}, {0, 0.8, 0}, {0, 0, 0}},
    {1, {0.6, 1.7, 5}, {0, 0.8, 0}, {0.1, 1, 0}},
};
/* Keys with something between them, to see that strides are kept. */
static const struct {
    EtdKey key;
    double junk;
} screen_keys[3] = {
    {{0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}, 1e30},
    {{0.25, {0.8, 0, 0.6, 0.25, 0, 1, 0, 0, -0.6, 0, 0.8, 0}}, 1e30},
    {{2, {1, 0, 0, 1, 0, 1, 0, 0.5, 0, 0, 1, 0}}, 1e30},
};
static const EtdKey ball_keys[2] = {
    {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
    {0.5, {1, 0, 0, 0, 0, 1, 0, 0.75, 0, 0, 1, 0}},
};

static void add_camera(EtdScene *scene, enum part without) {
    EtdFilm film;
    memset(&film, 0, sizeof film);
    film.struct_size = sizeof film;
    film.width = WIDTH;
    film.height = HEIGHT;
    DONE(scene, etd_scene_set_film(scene, &film));
    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = sizeof camera;
    camera.lens_radius = 0.05;
    memcpy(camera.eye, camera_keys[0].eye, sizeof camera.eye);
    memcpy(camera.target, camera_keys[0].target, sizeof camera.target);
    if (without != CAMERA_MOTION) {
        camera.motion = camera_keys;
        camera.motion_count = 2;
    }
    camera.shutter = without == SHUTTER ? NULL : times;
    DONE(scene, etd_scene_set_camera(scene, &camera));
}

static void add_materials(EtdScene *scene, enum part without) {
    const EtdImage relief = image_of(&bumps, 0), holes = image_of(&mask, 0.5f);
    EtdMaterial material;
    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    material.name = "relief";
    material.model = ETD_MODEL_PLASTIC;
    material.color[0] = 0.5f, material.color[1] = 0.4f, material.color[2] = 0.3f;
    material.roughness = 0.4f;
    material.normal_map = without == NORMALS ? NULL : &relief;
    material.normal_strength = without == NORMAL_STRENGTH ? 0 : 0.75f;
    DONE(scene, etd_scene_add_material(scene, &material, NULL));

    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    material.name = "net";
    material.bump_map = without == BUMPS ? NULL : &relief;
    material.bump_height = without == BUMP_HEIGHT ? 0 : 0.5f;
    material.color[0] = 0.8f, material.color[1] = 0.7f, material.color[2] = 0.6f;
    material.alpha_texture = without == MASK ? NULL : &holes;
    DONE(scene, etd_scene_add_material(scene, &material, NULL));

    material.name = "veil";
    material.bump_map = NULL;
    material.color[0] = material.color[1] = 0.3f, material.color[2] = 0.9f;
    material.alpha_texture = NULL;
    material.alpha = without == ALPHA ? 0 : 0.25f;
    DONE(scene, etd_scene_add_material(scene, &material, NULL));

    const EtdImage shine = image_of(&gloss, 0);
    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    material.name = "billiard ball";
    material.model = ETD_MODEL_PHONG;
    material.color[0] = material.color[1] = material.color[2] = 0.25f;
    material.specular[0] = material.specular[1] = material.specular[2] = 0.3f;
    material.specular_texture = without == GLOSS ? NULL : &shine;
    material.exponent = 20;
    DONE(scene, etd_scene_add_material(scene, &material, NULL));

    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    material.name = "car paint";
    material.model = ETD_MODEL_PRINCIPLED;
    material.color[0] = 0.5f, material.color[1] = 0.125f, material.color[2] = 0.25f;
    material.metallic = 0.5f;
    material.roughness = 0.5f;
    material.clear_coat = without == CLEAR_COAT ? 0 : 0.75f;
    material.clear_coat_roughness = without == COAT_ROUGHNESS ? 0 : 0.25f;
    material.clear_coat_ior = without == COAT_IOR ? 0 : 1.75f;
    DONE(scene, etd_scene_add_material(scene, &material, NULL));
}

static void add_shapes(EtdScene *scene, enum part without) {
    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    const double corner[3] = {-4, 0, 4}, edge_u[3] = {8, 0, 0}, edge_v[3] = {0, 0, -8};
    DONE(scene, etd_scene_add_rectangle(scene, &surface, corner, edge_u, edge_v, NULL));

    static const float positions[4][3] = {{-1, 0, 0}, {1, 0, 0}, {1, 1.5f, 0}, {-1, 1.5f, 0}};
    static const float uvs[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const uint32_t indices[2][3] = {{0, 1, 2}, {0, 2, 3}};
    EtdMesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.uvs = uvs[0];
    mesh.indices = indices[0];
    mesh.triangle_count = 2;
    const double placed[12] = {1, 0, 0, -0.5, 0, 1, 0, 0.125, 0, 0, 1, 0.5};
    surface.material = 1;
    surface.transform = placed;
    if (without != SHAPE_MOTION) {
        surface.motion = &screen_keys[0].key;
        surface.motion_count = 3;
        surface.motion_stride = sizeof screen_keys[0];
    }
    DONE(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL));

    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    surface.material = 3;
    const double center[3] = {-1.5, 0.5, 1};
    DONE(scene, etd_scene_add_sphere(scene, &surface, center, 0.5, NULL));
    surface.material = 4;
    const double beside[3] = {1.5, 0.5, 1};
    DONE(scene, etd_scene_add_sphere(scene, &surface, beside, 0.5, NULL));

    const EtdImage shine = image_of(&glow, 8);
    surface.material = 0;
    surface.two_sided_emission = 1;
    surface.emission[0] = surface.emission[1] = surface.emission[2] = 8;
    surface.emission_texture = without == GLOW ? NULL : &shine;
    const double from[3] = {0.5, 2.5, 0}, along_x[3] = {1, 0, 0}, along_z[3] = {0, 0, 1};
    DONE(scene, etd_scene_add_rectangle(scene, &surface, from, along_x, along_z, NULL));
}

static void add_pendulum(EtdScene *scene, enum part without) {
    uint32_t group = 0;
    DONE(scene, etd_scene_add_group(scene, "pendulum", &group));
    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    surface.material = 2;
    surface.group = group;
    const double center[3] = {0, 0.5, 0};
    DONE(scene, etd_scene_add_sphere(scene, &surface, center, 0.5, NULL));
    const double aside[12] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0};
    EtdInstance instance;
    memset(&instance, 0, sizeof instance);
    instance.struct_size = sizeof instance;
    instance.of = group;
    instance.transform = aside;
    if (without != INSTANCE_MOTION) {
        instance.motion = ball_keys;
        instance.motion_count = 2;
    }
    DONE(scene, etd_scene_add_instance(scene, &instance, NULL));
}

static EtdScene *build(enum part without) {
    EtdScene *scene = NULL;
    CHECK(etd_scene_create(&scene) == ETD_STATUS_OK);
    add_camera(scene, without);
    add_materials(scene, without);
    add_shapes(scene, without);
    add_pendulum(scene, without);
    const EtdImage panorama = image_of(&sky, 0);
    const double turned[12] = {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0};
    EtdLight light;
    memset(&light, 0, sizeof light);
    light.struct_size = sizeof light;
    light.panorama = &panorama;
    light.transform = without == TURN ? NULL : turned;
    DONE(scene, etd_scene_add_light(scene, &light));
    return scene;
}

/* Renders a scene to pixels with settings of this size, and to a file if there is one. */
static void render_by(size_t size_of_settings, EtdScene *scene, float pixels[HEIGHT][WIDTH][3],
                      const char *file) {
    EtdSettings settings;
    memset(&settings, 0x55, sizeof settings);
    memset(&settings, 0, size_of_settings);
    settings.struct_size = size_of_settings;
    settings.spp = SPP;
    EtdRender *render = NULL;
    DONE(scene, etd_scene_commit(scene, NULL));
    DONE(scene, etd_render_create(scene, &settings, &render));
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
    const size_t size = sizeof(float[HEIGHT][WIDTH][3]);
    CHECK(etd_render_read_pixels(render, &pixels[0][0][0], size, 0, 0) == ETD_STATUS_OK);
    if (file) {
        CHECK(etd_render_write(render, file) == ETD_STATUS_OK);
    }
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
}

/* Renders a scene to pixels, and to a file if there is one. */
static void render_to(EtdScene *scene, float pixels[HEIGHT][WIDTH][3], const char *file) {
    render_by(sizeof(EtdSettings), scene, pixels, file);
}

/* The keys that a camera has are the scene's, and a shutter that nobody names stays. */
static void a_shutter_stays(EtdScene *scene) {
    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = sizeof camera;
    camera.eye[2] = 5;
    EtdWork before, after;
    before.struct_size = after.struct_size = sizeof before;
    DONE(scene, etd_scene_work(scene, &before));
    DONE(scene, etd_scene_set_camera(scene, &camera));
    DONE(scene, etd_scene_work(scene, &after));
    CHECK(after.builds == before.builds && after.cameras == before.cameras + 1);
    /* Another one makes things move otherwise. */
    const double longer[2] = {0, 0.25};
    camera.shutter = longer;
    DONE(scene, etd_scene_set_camera(scene, &camera));
    DONE(scene, etd_scene_work(scene, &after));
    CHECK(after.builds == before.builds + 1);
}

/* A program of the first version has shorter structures; what stands behind them is none of the library's business. */
static void shorter_structures(void) {
    static float first[HEIGHT][WIDTH][3], later[HEIGHT][WIDTH][3];
    for (int is_first = 0; is_first < 2; is_first++) {
        EtdScene *scene = NULL;
        CHECK(etd_scene_create(&scene) == ETD_STATUS_OK);
        add_camera(scene, NOTHING);
        EtdCamera camera;
        EtdMaterial material;
        EtdSurface surface;
        EtdInstance instance;
        EtdLight light;
        const int junk = is_first ? 0x55 : 0;
        memset(&camera, junk, sizeof camera);
        memset(&material, junk, sizeof material);
        memset(&surface, junk, sizeof surface);
        memset(&instance, junk, sizeof instance);
        memset(&light, junk, sizeof light);
        const size_t sizes[5] = {offsetof(EtdCamera, shutter), offsetof(EtdMaterial, alpha_texture),
                                 offsetof(EtdSurface, emission_texture),
                                 offsetof(EtdInstance, motion), offsetof(EtdLight, transform)};
        memset(&camera, 0, sizes[0]);
        memset(&material, 0, sizes[1]);
        memset(&surface, 0, sizes[2]);
        memset(&instance, 0, sizes[3]);
        memset(&light, 0, sizes[4]);
        camera.struct_size = is_first ? sizes[0] : sizeof camera;
        material.struct_size = is_first ? sizes[1] : sizeof material;
        surface.struct_size = is_first ? sizes[2] : sizeof surface;
        instance.struct_size = is_first ? sizes[3] : sizeof instance;
        light.struct_size = is_first ? sizes[4] : sizeof light;
        camera.eye[2] = 4;
        material.color[0] = material.color[1] = material.color[2] = 0.5f;
        light.value[0] = light.value[1] = light.value[2] = 1;
        DONE(scene, etd_scene_set_camera(scene, &camera));
        DONE(scene, etd_scene_add_material(scene, &material, NULL));
        DONE(scene, etd_scene_add_group(scene, NULL, &surface.group));
        const double center[3] = {0, 0, 0};
        DONE(scene, etd_scene_add_sphere(scene, &surface, center, 1, NULL));
        instance.of = surface.group;
        DONE(scene, etd_scene_add_instance(scene, &instance, NULL));
        DONE(scene, etd_scene_add_light(scene, &light));
        render_by(is_first ? offsetof(EtdSettings, light_paths) : sizeof(EtdSettings), scene,
                  is_first ? first : later, NULL);
        CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    }
    CHECK(memcmp(first, later, sizeof first) == 0);
    CHECK(first[HEIGHT / 2][WIDTH / 2][0] > 0.1f && first[HEIGHT / 2][WIDTH / 2][0] < 0.9f);
}

static void wrong_arguments(void) {
    const EtdStatus argument = ETD_STATUS_INVALID_ARGUMENT, invalid = ETD_STATUS_INVALID_SCENE;
    EtdScene *scene = build(NOTHING);
    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = sizeof camera;
    camera.eye[2] = 1;
    const double reversed[2] = {1, 0};
    camera.shutter = reversed;
    FAILS(scene, etd_scene_set_camera(scene, &camera), invalid, "shutter");
    camera.shutter = NULL;
    camera.motion_count = 2;
    FAILS(scene, etd_scene_set_camera(scene, &camera), argument, "motion is null");
    EtdCameraKey keys[2];
    memcpy(keys, camera_keys, sizeof keys);
    camera.motion = keys;
    camera.motion_stride = 8;
    FAILS(scene, etd_scene_set_camera(scene, &camera), argument, "stride of 8");
    camera.motion_stride = 0;
    keys[0].time = 1;
    FAILS(scene, etd_scene_set_camera(scene, &camera), invalid, "order of time");
    keys[0].time = NAN;
    FAILS(scene, etd_scene_set_camera(scene, &camera), invalid, "finite times");
    memcpy(keys[1].target, keys[1].eye, sizeof keys[1].eye);
    FAILS(scene, etd_scene_set_camera(scene, &camera), invalid, "same point");
    camera.motion_count = SIZE_MAX;
    FAILS(scene, etd_scene_set_camera(scene, &camera), argument, "motion");

    EtdMaterial material;
    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    material.alpha = 2;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), invalid, "alpha");
    material.alpha = NAN;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), invalid, "alpha");
    material.alpha = 0;
    EtdImage image = image_of(&mask, 0);
    material.alpha_texture = &image;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), invalid, "alpha");
    material.alpha_texture = NULL;
    material.normal_map = &image;
    material.normal_strength = INFINITY;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), invalid, "normal_map");
    material.normal_strength = 0;
    material.bump_map = &image;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), invalid, "bump_map");
    material.normal_map = NULL;
    material.bump_height = INFINITY;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), invalid, "bump_map");
    image.width = 0;
    FAILS(scene, etd_scene_add_material(scene, &material, NULL), argument, "0 x 1 pixels");

    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    const double center[3] = {0, 0, 0};
    EtdKey flat = ball_keys[0];
    flat.transform[0] = 0;
    surface.motion = &flat;
    surface.motion_count = 1;
    FAILS(scene, etd_scene_add_sphere(scene, &surface, center, 1, NULL), invalid, "singular");

    EtdLight light;
    memset(&light, 0, sizeof light);
    light.struct_size = sizeof light;
    const double moved[12] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0};
    light.transform = moved;
    FAILS(scene, etd_scene_add_light(scene, &light), argument, "rotation");
    const double stretched[12] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    light.transform = stretched;
    FAILS(scene, etd_scene_add_light(scene, &light), invalid, "rotation");
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

int main(int argc, char **argv) {
    CHECK(argc == 2);
    write_picture(&bumps);
    write_picture(&mask);
    write_picture(&gloss);
    write_picture(&glow);
    write_picture(&sky);
    static float whole[HEIGHT][WIDTH][3], other[HEIGHT][WIDTH][3];
    EtdScene *scene = build(NOTHING);
    render_to(scene, whole, argv[1]);
    a_shutter_stays(scene);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    for (enum part part = NOTHING + 1; part < PARTS; part++) {
        scene = build(part);
        render_to(scene, other, NULL);
        if (memcmp(whole, other, sizeof whole) == 0) {
            fprintf(stderr, "part %d is not seen\n", (int)part);
            return 1;
        }
        CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    }
    shorter_structures();
    wrong_arguments();
    puts("all is well");
    return 0;
}
