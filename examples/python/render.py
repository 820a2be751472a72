"""Renders a ball under a sky through libetendue, by ctypes alone, into a NumPy array where NumPy is there.

    PREFIX=$HOME/.local python3 examples/python/render.py

Shows that the C interface is usable from elsewhere; a binding would declare the other structures in the same way. Those of
later versions are longer: what is not declared here takes its defaults.
"""

import ctypes
import os
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint32, c_uint64, c_void_p

PREFIX = os.environ.get("PREFIX", "/usr/local")
LIBRARY = ctypes.CDLL(os.path.join(PREFIX, "lib", "libetendue.so"))


class Structure(ctypes.Structure):
    """One that begins with its own size."""

    def __init__(self, **fields):
        super().__init__(ctypes.sizeof(type(self)), **fields)


class Camera(Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("eye", c_double * 3), ("target", c_double * 3), ("up", c_double * 3),
        ("fov", c_double), ("lens_radius", c_double), ("focus_distance", c_double),
    ]


class Film(Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("width", c_uint32), ("height", c_uint32), ("filter", c_int32),
        ("filter_radius", c_double),
    ]


class Material(Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("name", c_char_p), ("model", c_int32), ("color", c_float * 3),
        ("texture", c_void_p), ("specular", c_float * 3), ("exponent", c_float), ("roughness", c_float),
        ("ior", c_float), ("metallic", c_float), ("transmission", c_float), ("eta", c_float * 3),
        ("k", c_float * 3), ("one_sided", c_uint32),
    ]


class Surface(Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("name", c_char_p), ("material", c_uint32), ("group", c_uint32),
        ("emission", c_float * 3), ("two_sided_emission", c_uint32), ("transform", POINTER(c_double)),
    ]


class Light(Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("kind", c_int32), ("value", c_float * 3), ("panorama", c_void_p),
        ("position", c_double * 3), ("target", c_double * 3), ("direction", c_double * 3),
        ("cone", c_double), ("penumbra", c_double),
    ]


class Settings(Structure):
    _fields_ = [
        ("struct_size", c_size_t), ("flags", c_uint32), ("max_bounces", c_uint32), ("spp", c_uint64),
        ("seconds", c_double), ("error", c_double), ("confidence", c_double), ("seed", c_uint64),
        ("integrator", c_char_p), ("sampler", c_char_p), ("adaptive", c_char_p), ("roulette", c_char_p),
        ("occlusion_distance", c_double), ("cache_error", c_double), ("crop", c_uint32 * 4),
        ("light_paths", c_char_p), ("filter_sampling", c_char_p), ("reuse", c_char_p),
    ]


LIBRARY.etd_version.restype = c_char_p
LIBRARY.etd_scene_error.restype = c_size_t


def done(scene, status):
    """Raises what the library says, unless a call has succeeded."""
    if status != 0:
        text = ctypes.create_string_buffer(512)
        LIBRARY.etd_scene_error(scene, text, c_size_t(len(text)))
        raise RuntimeError(text.value.decode())


def ball(width, height):
    """A clay ball under an even sky, ready to be rendered."""
    scene = c_void_p()
    done(scene, LIBRARY.etd_scene_create(byref(scene)))
    done(scene, LIBRARY.etd_scene_set_camera(scene, byref(Camera(eye=(0, 1, 4)))))
    done(scene, LIBRARY.etd_scene_set_film(scene, byref(Film(width=width, height=height))))
    clay = Material(name=b"clay", color=(0.8, 0.5, 0.3))
    done(scene, LIBRARY.etd_scene_add_material(scene, byref(clay), None))
    center = (c_double * 3)(0, 0, 0)
    done(scene, LIBRARY.etd_scene_add_sphere(scene, byref(Surface()), center, c_double(1), None))
    done(scene, LIBRARY.etd_scene_add_light(scene, byref(Light(value=(1, 1, 1)))))
    done(scene, LIBRARY.etd_scene_commit(scene, None))
    return scene


def main():
    width, height = 96, 64
    scene = ball(width, height)
    render = c_void_p()
    done(scene, LIBRARY.etd_render_create(scene, byref(Settings(spp=64)), byref(render)))
    pixels = (c_float * (3 * width * height))()
    status = LIBRARY.etd_render_run(render, None) or LIBRARY.etd_render_read_pixels(
        render, pixels, c_size_t(ctypes.sizeof(pixels)), c_size_t(0), c_size_t(0)
    )
    if status != 0:
        sys.exit("the render failed")
    LIBRARY.etd_render_release(render)
    LIBRARY.etd_scene_release(scene)

    middle = 3 * (width * (height // 2) + width // 2)
    red, green, blue = pixels[middle : middle + 3]
    print(f"libetendue {LIBRARY.etd_version().decode()}: the ball is ({red:.3f}, {green:.3f}, {blue:.3f})")
    # A convex body under an even sky sends back its colour.
    if max(abs(red - 0.8), abs(green - 0.5), abs(blue - 0.3)) > 0.1:
        sys.exit("which it should not be")
    try:
        import numpy
    except ImportError:
        return
    picture = numpy.ctypeslib.as_array(pixels).reshape(height, width, 3)
    print(f"as an array of {picture.shape}, its mean is {picture.mean(axis=(0, 1))}")


if __name__ == "__main__":
    main()
