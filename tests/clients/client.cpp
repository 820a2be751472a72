// A client in C++: handles with owners, a lambda that watches, two threads.

#include <etendue.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

namespace {

struct Release {
    void operator()(EtdScene *scene) const { etd_scene_release(scene); }
    void operator()(EtdRender *render) const { etd_render_release(render); }
};
using Scene = std::unique_ptr<EtdScene, Release>;
using Render = std::unique_ptr<EtdRender, Release>;

void check(bool is_fine, const char *what) {
    if (!is_fine) {
        std::fprintf(stderr, "%s\n", what);
        std::exit(1);
    }
}

void done(const EtdScene *scene, EtdStatus status, const char *what) {
    if (status != ETD_STATUS_OK) {
        std::string text(etd_scene_error(scene, nullptr, 0), ' ');
        etd_scene_error(scene, text.data(), text.size() + 1);
        check(false, (std::string(what) + ": " + text).c_str());
    }
}

// A structure of the library, all of it at its defaults.
template <typename T> T make() {
    static_assert(std::is_standard_layout_v<T> && std::is_trivial_v<T>);
    T made{};
    made.struct_size = sizeof made;
    return made;
}

Scene furnace() {
    EtdScene *raw = nullptr;
    check(etd_scene_create(&raw) == ETD_STATUS_OK, "create");
    Scene scene(raw);
    auto camera = make<EtdCamera>();
    camera.eye[2] = 4;
    done(raw, etd_scene_set_camera(raw, &camera), "camera");
    auto film = make<EtdFilm>();
    film.width = film.height = 16;
    done(raw, etd_scene_set_film(raw, &film), "film");
    auto material = make<EtdMaterial>();
    material.model = ETD_MODEL_PRINCIPLED;
    for (float &channel : material.color) {
        channel = 1;
    }
    material.metallic = 1;
    material.roughness = 0.5F;
    done(raw, etd_scene_add_material(raw, &material, nullptr), "material");
    auto surface = make<EtdSurface>();
    const std::array<double, 3> center{0, 0, 0};
    done(raw, etd_scene_add_sphere(raw, &surface, center.data(), 1, nullptr), "sphere");
    // A sky from a picture of one colour.
    const std::vector<float> sky(3 * 4 * 2, 0.5F);
    auto image = make<EtdImage>();
    image.width = 4;
    image.height = 2;
    image.rgb = sky.data();
    image.scale = 2;
    auto light = make<EtdLight>();
    light.panorama = &image;
    done(raw, etd_scene_add_light(raw, &light), "light");
    done(raw, etd_scene_commit(raw, nullptr), "commit");
    return scene;
}

std::vector<float> render(const EtdScene *scene, EtdWatch *watch) {
    auto settings = make<EtdSettings>();
    settings.spp = 32;
    EtdRender *raw = nullptr;
    done(scene, etd_render_create(scene, &settings, &raw), "render");
    Render render(raw);
    check(etd_render_run(raw, watch) == ETD_STATUS_OK, "run");
    std::vector<float> pixels(16 * 16 * 3);
    check(etd_render_read_pixels(raw, pixels.data(), pixels.size() * sizeof(float), 0, 0) ==
              ETD_STATUS_OK,
          "read");
    return pixels;
}

} // namespace

int main() {
    Scene scene = furnace();
    std::atomic<unsigned> calls{0};
    auto watch = make<EtdWatch>();
    watch.user = &calls;
    watch.progress = [](void *user, const EtdProgress *) -> std::int32_t {
        ++*static_cast<std::atomic<unsigned> *>(user);
        return 0;
    };
    std::vector<float> first, second;
    std::thread thread([&] { first = render(scene.get(), nullptr); });
    second = render(scene.get(), &watch);
    thread.join();
    check(calls > 0, "nobody was told of the progress");
    check(first == second, "two renders of one scene differ");
    // The sky is seen beside the ball, and sent back by it but for noise.
    check(second[0] > 0.999F && second[0] < 1.001F, "the sky");
    const float middle = second[3 * (16 * 8 + 8)];
    check(middle > 0.85F && middle < 1.15F, "the ball");
    std::puts("all is well");
}
