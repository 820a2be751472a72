/* A small scene in memory, which several clients use. */

#ifndef SMALL_SCENE_H
#define SMALL_SCENE_H

#include "check.h"

/* A grey floor at y = 0, a ball of radius 1 on it, which is the only shape of a group, and an even sky of radiance 1. */
static EtdScene *make_scene(uint32_t width, uint32_t height) {
    EtdScene *scene = NULL;
    CHECK(etd_scene_create(&scene) == ETD_STATUS_OK);

    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = sizeof camera;
    camera.eye[1] = 2.0;
    camera.eye[2] = 6.0;
    camera.target[1] = 1.0;
    DONE(scene, etd_scene_set_camera(scene, &camera));

    EtdFilm film;
    memset(&film, 0, sizeof film);
    film.struct_size = sizeof film;
    film.width = width;
    film.height = height;
    DONE(scene, etd_scene_set_film(scene, &film));

    EtdMaterial material;
    memset(&material, 0, sizeof material);
    material.struct_size = sizeof material;
    material.name = "grey";
    material.color[0] = material.color[1] = material.color[2] = 0.5f;
    uint32_t grey = 99;
    DONE(scene, etd_scene_add_material(scene, &material, &grey));
    CHECK(grey == 0);

    /* Vertices with something between them, to see that strides are kept. */
    struct {
        float position[3];
        float junk;
        float uv[2];
    } vertices[4];
    static const float corners[4][2] = {{-5, 5}, {5, 5}, {5, -5}, {-5, -5}};
    for (int i = 0; i < 4; i++) {
        vertices[i].position[0] = corners[i][0];
        vertices[i].position[1] = 0;
        vertices[i].position[2] = corners[i][1];
        vertices[i].junk = 1e30f;
        vertices[i].uv[0] = vertices[i].uv[1] = (float)i;
    }
    static const uint32_t indices[2][3] = {{0, 1, 2}, {0, 2, 3}};
    EtdMesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = &vertices[0].position;
    mesh.vertex_count = 4;
    mesh.position_stride = sizeof vertices[0];
    mesh.uvs = vertices[0].uv;
    mesh.uv_stride = sizeof vertices[0];
    mesh.indices = &indices[0][0];
    mesh.triangle_count = 2;
    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    surface.name = "floor";
    surface.material = grey;
    uint32_t floor = 99;
    DONE(scene, etd_scene_add_mesh(scene, &surface, &mesh, &floor));
    CHECK(floor == 0);

    uint32_t group = 99;
    DONE(scene, etd_scene_add_group(scene, "ball", &group));
    CHECK(group == 1);
    surface.name = "ball";
    surface.group = group;
    const double origin[3] = {0, 0, 0};
    DONE(scene, etd_scene_add_sphere(scene, &surface, origin, 1.0, NULL));
    const double place[12] = {1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0};
    EtdInstance instance;
    memset(&instance, 0, sizeof instance);
    instance.struct_size = sizeof instance;
    instance.of = group;
    instance.transform = place;
    DONE(scene, etd_scene_add_instance(scene, &instance, NULL));

    EtdLight sky;
    memset(&sky, 0, sizeof sky);
    sky.struct_size = sizeof sky;
    sky.kind = ETD_LIGHT_KIND_ENVIRONMENT;
    sky.value[0] = sky.value[1] = sky.value[2] = 1.0f;
    DONE(scene, etd_scene_add_light(scene, &sky));
    return scene;
}

#endif
