"""What the page of the scene format says about path-traced scenes."""

PATHS = """## Mode `pathtracer`

* **Light.** Intensities and emissions are radiometric: radiance of what shines (W / (m^2 sr), with the scene unit as
  m), W / sr of points and spots, W / m^2 of a directional light. With `exposure` 0.1, a pixel of radiance 1 is white.
  `ambientlight` does not count; `backgroundcolor`, or the `environment` in its place, lights the scene from all
  around. A white surface (reflectance 1) that faces a point light of intensity pi at distance 1 is white.
* **Paths.** `nbounces` counts the surfaces that light may meet on its way from a light to the camera: 0 shows only
  what shines by itself, 1 adds direct light, 2 light by way of one more surface. With `roulette`, paths end at random
  from the fourth bounce on, and those that go on count for them: the mean is the same. Without, all go on to the end.
* **Samples.** Each of the `samples` rays goes through a random point of the pixel, also if there is only one. The noise
  falls with the root of their number. `sobol` spreads them evenly and is the better choice; `independent` draws them
  at random. A pixel, sample and seed determine a ray, however the work is divided.
* **Filters.** A pixel is the mean of the rays around its centre, weighted by the `filter`: `box` (the pixel itself),
  `tent` (a cone as wide as two pixels), `gaussian` (standard deviation half a pixel, lowered to 0 at a distance of two
  pixels), `mitchell` (the cubic with B = C = 1/3, which sharpens edges). They are those of Mitsuba.
* **Pictures.** 8-bit pictures are encoded by the curve of sRGB; EXR files hold linear radiance.
* **Textures.** Colours in 8-bit images are decoded from sRGB before texels are combined. Where an image gives a number
  (`alpha`, `roughness`, `metallic`), its red channel counts, from 0 to 1 as written. A file or checkerboard can stand
  wherever the tables above allow one; `texturefilter`, `texturewrap`, `scaleU` and `scaleV` of the material place it.
* **Normal maps.** A pixel holds 0.5 + 0.5 n with n in the frame of the texture: x along growing u, y = z cross x,
  which is along growing v (down in the picture) unless the coordinates are mirrored, z out of the surface. Maps whose
  green means "up" have to be inverted in green.
* **Bump maps.** The red channel, from 0 to 1 times `bumpscale` scene units, is the height above the surface; texels are
  always combined bilinearly, because what counts is the slope.
* **Thin lens.** Rays start all over a round lens of radius `apertureRadius`; the plane at `focusDistance` along the
  direction of view, or that of `lookAt`, is sharp. An aperture of 0 is a pinhole.

### Lights

* `pointlight`: intensity / distance^2 arrives. Its shadows are hard, and no ray hits it.
* `spot`: likewise in a cone of half angle `cutoff`: the full intensity within `beamwidth`, from there falling linearly
  with the angle.
* `directional`: from infinitely far away along `direction`, the same everywhere.
* `arealight`, `disklight`: sheets of radiance `intensity` that are seen, throw soft shadows, and are black but for
  their light. With `twosided` false only the side of the normal (u x v of an `arealight`) shines.
* `environment`: a picture by longitude and latitude. Its middle is seen in direction +z and its top in +y; without
  `rotation`, the direction d is at u = atan2(-d.x, -d.z) / 2 pi, v = acos(d.y) / pi. EXR and HDR files hold radiance,
  8-bit images are decoded from sRGB. Directions are chosen by brightness, so a small sun is no problem. One is
  allowed.
* `emission` of shapes: spheres, meshes, triangles, rectangles and disks are sampled like lamps. Boxes, cylinders,
  convex volumes and planes shine too, but are found by chance only, which is noisy where they are small.

### Materials

Without `bsdf`, the coursework's material is used in a form that keeps energy: a Lambertian base `kd` times the
diffuse colour, a Blinn-Phong lobe `ks` times the specular colour that is normalised so that it reflects that share at
normal incidence (with n.h to the power `specularexponent`), and `reflectivity` for mirror or glass in their place.
Where `kd` and `ks` together would reflect more than arrives, both are divided by their sum. `roughness` blurs the
mirror.

With `bsdf`, one of these. Kinds that only reflect look the same from both sides; glass has an inside, for which the
rule of nested glass above holds with its `ior`.

* `diffuse`: the same radiance in all directions, `reflectance` of what arrives.
* `mirror`: a perfect mirror.
* `conductor`, `roughconductor`: metals by Fresnel's equations for the complex index `eta` + i `k`, for red, green and
  blue.
* `dielectric`, `roughdielectric`: glass by Fresnel's equations. Refracted radiance changes by the square of the ratio
  of indices, and back when it leaves. Light passes a thick pane with two surfaces; there is no absorption inside.
* `plastic`: a smooth coat of index `ior` over a diffuse base, with the light that goes back and forth between them.
* `principled`: the artists' material: `metallic` blends metal and dielectric, `clearcoat` adds a second highlight,
  `sheen` one at grazing angles; `anisotropic` stretches the first along u.
* Rough kinds have facets whose normals are distributed by `ggx` or `beckmann` with the width `alpha` (0.1 is satin,
  0.5 matt, 0 smooth) and shadow each other [Walter 2007]; light that is scattered twice between facets is lost, so
  very rough metals are somewhat too dark. `roughness` of `principled` is the root of alpha.
"""
