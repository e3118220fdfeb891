"""The coursework's material as a Mitsuba plugin: Lambert, a normalised Blinn-Phong lobe, a share of mirror or glass.

    value = (1 - s) (kd Cd / pi + ks Cs N(e) (n . h)^e) / m cos + s f_other
    N(e) = (e + 2) (e + 4) / (8 pi (2^(-e/2) + e)),  m = max(1, kd max Cd + ks max Cs)

`other` is a nested plugin (`conductor`, `roughconductor` or `dielectric`). Stock `blendbsdf` is no substitute: it loses
energy where one of the two is a delta function. Importing this module registers `coursework`; a variant must be set.
"""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi

TINY = 1e-8  # keeps power(0, 0) and divisions by a vanishing cosine finite


def _turned(v, sign):
    """Return a local direction with z multiplied by `sign`."""
    return mi.Vector3f(v.x, v.y, v.z * sign)


class Coursework(mi.BSDF):
    """See the module; lit from both sides, unless `other` transmits, which sees the sides as they are."""

    def __init__(self, properties):
        mi.BSDF.__init__(self, properties)
        self.diffuse = properties.get_texture("diffusecolor", 0.5)
        self.specular = properties.get_texture("specularcolor", 1.0)
        self.kd, self.ks = float(properties["kd"]), float(properties["ks"])
        self.exponent = e = float(properties["exponent"])
        self.share = float(properties["share"])
        self.other = properties["other"] if "other" in properties else None
        assert (self.other is not None) == (self.share > 0)
        self.peak = (e + 2) * (e + 4) / (8 * math.pi * (2 ** (-e / 2) + e))
        self.highlight = self.ks / max(self.kd + self.ks, TINY)  # probability of the lobe
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        components = [mi.BSDFFlags.GlossyReflection | both, mi.BSDFFlags.DiffuseReflection | both]
        if self.other is not None:
            components += [self.other.flags(k) | both for k in range(self.other.component_count())]
        self.m_components = components
        flags = mi.BSDFFlags(0)
        for component in components:
            flags |= component
        self.m_flags = flags
        self.glass = self.other is not None and mi.has_flag(self.other.flags(), mi.BSDFFlags.Transmission)

    def _front(self, si):
        """Return the interaction as `other` shall see it, and the sign by which directions are turned for it."""
        sign = dr.select(si.wi.z < 0, mi.Float(-1), mi.Float(1))
        if self.glass:
            return si, mi.Float(1)
        front = mi.SurfaceInteraction3f(si)
        front.wi = _turned(si.wi, sign)
        return front, sign

    def _local(self, si, wo, active):
        """Return value and density of the two lobes, without the share of `other`."""
        sign = dr.sign(si.wi.z)
        wi, wo = _turned(si.wi, sign), _turned(wo, sign)
        h = dr.normalize(wi + wo)
        lobe = dr.power(dr.maximum(h.z, TINY), self.exponent)
        cd, cs = self.diffuse.eval(si, active), self.specular.eval(si, active)
        limit = dr.maximum(1, self.kd * dr.max(cd) + self.ks * dr.max(cs))
        value = (self.kd * dr.inv_pi * cd + self.ks * self.peak * lobe * cs) / limit * wo.z
        of_lobe = (self.exponent + 1) / (8 * math.pi) * lobe / dr.maximum(dr.dot(wo, h), TINY)
        pdf = (1 - self.highlight) * dr.inv_pi * wo.z + self.highlight * of_lobe
        lit = active & (wi.z > 0) & (wo.z > 0)
        return dr.select(lit, value, 0), dr.select(lit, pdf, 0)

    def eval_pdf(self, ctx, si, wo, active=True):
        """Return value times cosine and density, both without delta parts."""
        value, pdf = self._local(si, wo, active)
        if self.other is None:
            return value, pdf
        front, sign = self._front(si)
        other, other_pdf = self.other.eval_pdf(ctx, front, _turned(wo, sign), active)
        return dr.lerp(value, other, self.share), dr.lerp(pdf, other_pdf, self.share)

    def eval(self, ctx, si, wo, active=True):
        """Return value times cosine."""
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        """Return the density of `sample` per steradian."""
        return self.eval_pdf(ctx, si, wo, active)[1]

    def _sample_local(self, si, u, u2):
        """Return a direction from one of the two lobes."""
        sign = dr.sign(si.wi.z)
        wi = _turned(si.wi, sign)
        cosine = dr.power(1 - u2.y, 1 / (self.exponent + 1))
        sine, phi = dr.safe_sqrt(1 - cosine * cosine), 2 * math.pi * u2.x
        h = mi.Vector3f(sine * dr.cos(phi), sine * dr.sin(phi), cosine)
        reflected = 2 * dr.dot(wi, h) * h - wi
        return _turned(dr.select(u < self.highlight, reflected, mi.warp.square_to_cosine_hemisphere(u2)), sign)

    def sample(self, ctx, si, sample1, sample2, active=True):
        """Return a BSDFSample3f and its weight."""
        taken = mi.Bool(active) & (sample1 < self.share)
        bs = dr.zeros(mi.BSDFSample3f, dr.width(si.wi))
        u = (sample1 - self.share) / max(1 - self.share, TINY)
        bs.wo, bs.eta, bs.sampled_component = self._sample_local(si, u, sample2), mi.Float(1), mi.UInt32(0)
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        delta, weight_delta = mi.Bool(False), mi.Color3f(0)
        if self.other is not None:
            front, sign = self._front(si)
            ahead, weight_delta = self.other.sample(ctx, front, sample1 / self.share, sample2, taken)
            delta = taken & mi.has_flag(ahead.sampled_type, mi.BSDFFlags.Delta)
            bs.wo = dr.select(taken, _turned(ahead.wo, sign), bs.wo)
            bs.eta = dr.select(taken, ahead.eta, bs.eta)
            bs.sampled_type = dr.select(taken, ahead.sampled_type, bs.sampled_type)
            bs.pdf = self.share * ahead.pdf
        value, pdf = self.eval_pdf(ctx, si, bs.wo, active)
        bs.pdf = dr.select(delta, bs.pdf, pdf)
        weight = dr.select(delta, weight_delta, value / dr.maximum(pdf, 1e-30))
        return bs, dr.select(mi.Bool(active) & (bs.pdf > 0), weight, 0)

    def to_string(self):
        """Return the name."""
        return "Coursework[]"


mi.register_bsdf("coursework", Coursework)
