"""Mitsuba's side of the comparison of meshes: its scenes of one mesh, traced by Embree.

Mitsuba 3.9.1 asks Embree for its best hierarchies (RTC_BUILD_QUALITY_HIGH, which splits triangles between nodes), and
not for the robust test of triangles (`embree_use_robust_intersections` is off, as is its default), which costs time
[src/render/scene_embree.inl]. Building is `mi.load_dict` of a scene with one mesh that is in memory already.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from benchmarks.lanes import done, lanes, vectors

if mi.variant() is None:
    mi.set_variant("llvm_ad_rgb")

NEVER = 1000  # depth from which paths may end by Russian roulette


def mesh_of(vertices, faces, **properties):
    """Return a mesh of (V, 3) float32 and (F, 3) uint32 without normals; properties are parts such as its `bsdf`."""
    settings = mi.Properties()
    for name, part in properties.items():
        settings[name] = part
    mesh = mi.Mesh("mesh", len(vertices), len(faces), props=settings)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = lanes(mi.Float, vertices.ravel())
    parameters["faces"] = lanes(mi.UInt32, faces.ravel())
    parameters.update()
    dr.sync_thread()
    return mesh


def build(mesh):
    """Return a scene of the mesh alone, ready to be traced."""
    scene = mi.load_dict({"type": "scene", "mesh": mesh})
    dr.sync_thread()
    return scene


def rays_of(host):
    """Return HostRays as Mitsuba's rays, which end where shadow rays end."""
    ray = mi.Ray3f(vectors(mi.Point3f, mi.Float, host.o), vectors(mi.Vector3f, mi.Float, host.d))
    if host.distance is not None:
        ray.maxt = lanes(mi.Float, host.maxt)
    return ray


def closest(scene, ray, coherent):
    """Return distance and triangle of the closest hits; `coherent` is the hint that neighbouring rays are alike."""
    hit = scene.ray_intersect_preliminary(ray, coherent=coherent)
    return done(hit.t, hit.prim_index)


def occluded(scene, ray, coherent):
    """Return, as a tuple of one, whether anything is hit before the rays' ends."""
    return done(scene.ray_test(ray, coherent=coherent))


class DiffusePath:
    """A DiffusePicture by Mitsuba's `path`."""

    def __init__(self, vertices, faces, picture):
        bsdf = mi.load_dict({"type": "diffuse", "reflectance": _grey(picture.reflectance)})
        self._scene = mi.load_dict({
            "type": "scene", "mesh": mesh_of(vertices, faces, mesh_bsdf=bsdf), "light": _light(picture.light),
            "sensor": _sensor(picture),
            "integrator": {"type": "path", "max_depth": picture.max_depth, "rr_depth": NEVER, "hide_emitters": False},
        })  # fmt: skip

    def render(self, samples, seed):
        """Return the picture (height, width, 3) in memory."""
        (picture,) = done(mi.render(self._scene, spp=samples, seed=seed))
        return picture


def _grey(value):
    """Return a colour of three equal channels, or radiance."""
    return {"type": "rgb", "value": float(value)}


def _light(light):
    """Return the square, which shines towards negative y."""
    placed = mi.ScalarTransform4f().translate(light.centre).rotate([1, 0, 0], 90).scale(light.side / 2)
    return {"type": "rectangle", "to_world": placed, "emitter": {"type": "area", "radiance": _grey(light.radiance)}}


def _sensor(picture):
    """Return the camera."""
    looking = mi.ScalarTransform4f().look_at(origin=picture.view.eye, target=[0, 0, 0], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": picture.size, "height": picture.size, "rfilter": {"type": "box"},
            "pixel_format": "rgb"}  # fmt: skip
    return {"type": "perspective", "fov": picture.view.fov_deg, "fov_axis": "y", "to_world": looking, "film": film,
            "sampler": {"type": "independent"}}  # fmt: skip
