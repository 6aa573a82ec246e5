#!/usr/bin/env python3
"""slipstep convert: faults of HBI, interact, Quake-DFN and PyQuake3D. Small files of each become the cells that they
describe, in the order of their parameters, and a run takes them; others are refused by one line that names the line."""

import unittest

from test_convert_sources import SourcesTest
import h5py
import numpy as np

from slipstep.formats import faults, said

HBI = """problem 3dph !a plane
imax 4
jmax 3
ds 0.5 !km
dipangle 30.0
crake 90.0
vpl 1d-9
b 0.03
f0 0.6
sigmainit 25.0
parameterfromfile T
parameter_file "examples/params.dat"
parameter_file_ncol 3
"""
PARAMS = "a\tdc\ttau\n" + "".join(f"{0.01 + 0.001 * k}\t{0.1 + 0.01 * k}\t{10.0 + k}\n" for k in range(12))
INTERACT = """0.0 -4.95 -0.5 0.0 90.0 0.5 0.25 0
1.0 2.0 -3.0 30.0 60.0 0.5 0.5 1
1.0 2.0 -3.0 30.0 120.0 0.5 0.5 2
"""
DFN = """SwitchSS/RN\tShearMod\tPoissonRatio\tR_Density\tCrit_TooClose\tTooCloseNormal_Multiplier\tMinimum_NS
2.0\t3.2e10\t0.25\t2700.0\t1.05\t0.6\t2.0e6
Ctr_X\tCtr_Y\tCtr_Z\tSt_L\tDip_L\tStAng\tDipAng\tLR/RN\ta\tb\tDc\tTheta_i\tV_i\tFric_i\tSig0\tSigGrad\tV_Const\tMaxLeng
1000.0\t2000.0\t3000.0\t4000.0\t2000.0\t90.0\t30.0\t-1.0\t0.004\t0.03\t0.13\t1.3e8\t1e-9\t0.6\t1e6\t1000\t0.0\t1500.0
0.0\t9000.0\t5000.0\t1000.0\t1000.0\t0.0\t60.0\t1.0\t0.01\t0.02\t0.13\t1.3e8\t1e-9\t0.6\t2.5e7\t0.0\t2e-9\t1e10
"""
MSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 -1
2 2 0 -1
3 2 0 -3
4 0 0 -3
$EndNodes
$Elements
2
1 2 2 0 1 1 2 3
2 2 2 0 1 1 3 4
$EndElements
"""
PYQUAKE = """#Files
InputHetoparamter: True
Inputparamter file: params.dat
Scale_km: True
Lame constants: 3e10
Shear modulus: 3e10
Rock density: 2700
Half space: True
Plate loading rate: 1e-9
"""
RATE = ("-ts_max_steps", "1", "-ts_max_time", "1")


class Faults(SourcesTest):
    def run_of(self, name, *options, **normal):
        """The program fault takes cells and parameters of a converted file."""
        self.plot("convert", self.path(name), "--projection", "sphere", *options, self.path("made.h5"))
        with h5py.File(self.path("made.h5")) as file:
            words = ("-fault_friction_law rate_and_state -fault_loading_rate 1e-9".split()
                     + ([] if "normal_stress" in file else ["-fault_normal_stress", "20e6"]))
        self.fault("-fault_mesh", "made.h5", "-fault_parameters", "made.h5", *words, *RATE)

    def test_hbi(self):
        """Column by column along strike from the top, to the south by 30 degrees; MPa and km."""
        self.put("params.dat", PARAMS)
        model = faults.read_hbi(self.put("a.in", HBI.replace("examples/", "")), None)
        i, j = (k.ravel() for k in np.meshgrid(np.arange(4), np.arange(3), indexing="ij"))
        np.testing.assert_allclose(model.cells[:, 1], 500 * (i - 1.5))
        np.testing.assert_allclose(model.cells[:, 2], 250 * (j + 0.5), atol=1e-9)
        np.testing.assert_allclose(model.cells[:, 0], -500 * np.sqrt(0.75) * (j + 0.5))
        np.testing.assert_allclose(model.cells[:, 3:], [[500, 500, 90, 30]] * 12)
        np.testing.assert_allclose(model.fields["initial_traction"][0], 1e6 * (10 + np.arange(12)))
        np.testing.assert_allclose(model.fields["friction_slip"][0], 0.1 + 0.01 * np.arange(12))
        np.testing.assert_allclose(model.fields["normal_stress"][0], 25e6)
        np.testing.assert_allclose(model.rake, 90)
        self.assertEqual((model.options["loading_rate"], model.options["shear_modulus"]), (1e-9, 32.04e9))
        self.run_of("a.in")

    def test_hbi_keys(self):
        """Constants and the law of an input are taken, its defaults stand where it is silent, and what is not used is
        named."""
        self.put("params.dat", PARAMS)
        text = HBI.replace("examples/", "")
        model = faults.read_hbi(self.put("a.in", text + "vref 2e-9\nevlaw slip\nrigid 30.0\nvs 3.0\npois 0.3\npfinit "
                                                        "5.0\nno_such_key 1\n"), None)
        for name, value in (("friction_reference_rate", 2e-9), ("shear_modulus", 30e9), ("density", 30e9 / 3000 ** 2),
                            ("poisson_ratio", 0.3)):
            self.assertAlmostEqual(model.options[name] / value, 1, 12)
        self.assertEqual(model.options["state_law"], "slip")
        self.assertEqual(model.dropped, ["keys parameter_file_ncol, pfinit, no_such_key"])
        silent = faults.read_hbi(self.put("b.in", text), None)
        # fault's own are the same, aging and 1e-6 m/s
        self.assertFalse({"state_law", "friction_reference_rate"} & set(silent.options))
        self.refuse("c.in", text + "evlaw composite\n", "line 14: evlaw composite")
        self.refuse("d.in", text + "pois 0.5\n", "line 14: .*pois 0.5")
        self.refuse("e.in", text + "vs 0\n", "line 14: .*vs 0")

    def test_bounds_of_the_program(self):
        """What fault refuses or doubts of fields is refused or said when they are written."""
        self.put("params.dat", PARAMS)
        text = HBI.replace("examples/", "")
        self.refuse("a.in", text.replace("b 0.03", "b -0.03"), "friction_b of cell 1 is -0.03")
        self.put("b.in", text.replace("sigmainit 25.0", "sigmainit 25e-6"))
        code, _, err = self.main("convert", self.path("b.in"), self.path("out.h5"))
        self.assertEqual(code, 0)
        self.assertRegex(err, "slipstep convert: warning: .*b.in: /normal_stress .*25 Pa")

    def test_small_numbers_are_said(self):
        """Slip rates are no rounding of 0, and lengths that are only that are 0."""
        self.assertEqual(said.span(np.array([2e-9, 3e-9]), digits=None), "2e-09 to 3e-09")
        self.assertEqual(said.span(np.array([2e-9, 2e-9]), digits=None), "2e-09")
        self.assertEqual(said.span(np.array([-6e-16, 0.0])), "0")

    def test_hbi_refused(self):
        text = HBI.replace("examples/", "")
        self.refuse("a.in", text, "params.dat")
        self.put("b.in", text)
        for params, message in ((PARAMS[:-9], "line 13: 2 numbers"),
                                ("".join(PARAMS.splitlines(True)[:-1]), "ends after line 12 with 11 rows"),
                                (PARAMS.split("\n", 1)[1], "line 1")):
            self.put("params.dat", params)
            self.refused("convert", f"params.dat,? {message}", self.path("b.in"), self.path("out.h5"))
        self.refuse("d.in", text.replace("3dph", "2dp"), "line 1: the problem 2dp")
        self.refuse("e.in", text.replace("ds 0.5", "ds half"), 'line 4: "half"')
        self.refuse("f.in", text.replace("imax 4\n", ""), "imax")

    def test_interact(self):
        """x east and y north, half lengths; a dip of 120 degrees is 60 degrees of the other strike."""
        model = faults.read_interact(self.put("geom.in", INTERACT), None, 90.0, "km")
        np.testing.assert_allclose(model.cells, [[-4950, 0, 500, 1000, 500, 0, 90],
                                                 [2000, 1000, 3000, 1000, 1000, 30, 60],
                                                 [2000, 1000, 3000, 1000, 1000, 210, 60]])
        np.testing.assert_allclose(model.rake, [90, 90, -90])
        self.assertEqual(model.fault.tolist(), [0, 1, 2])
        self.put("geom.in", "".join(INTERACT.splitlines(True)[:2]))
        self.run_of("geom.in", "--unit", "km")
        self.refuse("a.in", INTERACT, "--unit m")
        self.refuse("b.in", INTERACT.replace("0.5 0.5 1", "0.5 0.5"), "line 2: 7 words")
        self.refuse("c.in", INTERACT.replace("0.5 0.25 0", "-0.5 -0.25 0"), "line 1: .*-0.5")

    def test_quake_dfn(self):
        """3 x 2 cells of a plane that strikes north and dips to the east, reverse; one that strikes east, dips to the
        south, and creeps."""
        model = faults.read_dfn(self.put("Input_BulkFaultGeometry.txt", DFN), None)
        i, j = (k.ravel() for k in np.meshgrid(np.arange(3) - 1, np.arange(2) - 0.5))
        np.testing.assert_allclose(model.cells[:6, 0], 2000 + 4000 / 3 * i)
        np.testing.assert_allclose(model.cells[:6, 1], 1000 + 1000 * np.sqrt(0.75) * j)
        np.testing.assert_allclose(model.cells[:6, 2], 3000 + 500 * j)
        np.testing.assert_allclose(model.cells[6], [9000, 0, 5000, 1000, 1000, 90, 60])
        np.testing.assert_allclose(model.cells[:6, 5:], [[0, 30]] * 6)
        np.testing.assert_allclose(model.rake, [90] * 6 + [-90])
        np.testing.assert_allclose(model.fields["normal_stress"][0], [*(1e6 + 1000 * (3000 + 500 * j)), 2.5e7])
        np.testing.assert_allclose(model.fields["creep"][0], [0] * 6 + [1])
        np.testing.assert_allclose(model.fields["friction_reference"][0][0], 0.6 - 0.03 * np.log(1.3e8 * 1e-9 / 0.13))
        self.run_of("Input_BulkFaultGeometry.txt")
        lines = DFN.splitlines(True)
        self.refuse("a.txt", lines[0] + lines[1] + lines[3], "line 3")
        self.refuse("b.txt", DFN[:-12], "line 5: 16 words")
        self.refuse("c.txt", DFN.replace("30.0\t-1.0", "190.0\t-1.0"), "line 4")

    def test_pyquake(self):
        """Two triangles of 2 km2, x east and z up, with a row of parameters each."""
        self.put("fault.msh", MSH)
        self.put("params.dat", "".join(f"{30 + k} 0.01 0.02 0.1 0.6 {12 + k} 25 1e-9 0 0\n" for k in range(2)))
        model = faults.read_pyquake(self.put("parameter.txt", PYQUAKE), None)
        self.assertEqual(model.dropped, [])
        more = faults.read_pyquake(self.put("parameter.txt", PYQUAKE + "No such line: 1\n"), None)
        self.assertEqual(more.dropped, ["key No such line"])
        np.testing.assert_allclose(model.area, 2e6)
        np.testing.assert_allclose(model.cells[:, 2], [5e3 / 3, 7e3 / 3])
        np.testing.assert_allclose(model.cells[:, 5:], [[90, 90]] * 2, atol=1e-9)
        np.testing.assert_allclose(model.rake, [30, 31])
        np.testing.assert_allclose(model.fields["initial_traction"][0], [12e6, 13e6])
        self.assertEqual(model.options["poisson_ratio"], 0.25)
        self.run_of("parameter.txt")
        np.testing.assert_allclose(self.get("made.h5", "initial_traction"), [12e6, 13e6])
        self.assertRegex(self.plot("convert", self.path("made.h5")), "initial_traction: +1.2e\\+07 to 1.3e\\+07 Pa")
        self.plot("convert", self.path("made.h5"), "--figure", self.path("out.png"))
        self.look(self.path("out.png"))
        self.put("params.dat", "30 0.01 0.02 0.1 0.6 12 25 1e-9 0 0\n")
        self.refused("convert", "params.dat .*line 1 .*1 rows", self.path("parameter.txt"), self.path("new.h5"))
        self.put("other.msh", MSH)
        self.refused("convert", r"2 meshes \(.msh, .inp\) ", self.path("parameter.txt"), self.path("new.h5"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
