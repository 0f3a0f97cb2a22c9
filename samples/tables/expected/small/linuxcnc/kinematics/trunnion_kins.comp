component trunnion_kins "Kinematics of a trunnion table with its measured errors";
description """
Tool-centre-point kinematics XYZAC of a tilting rotary table, like xyzac-trt-kins, for the machine as it was measured:
joints go where the real tool meets the real workpiece. All numbers are in this file; nothing is read at run time.

Pins: trunnion_kins.x-rot-point y-rot-point z-rot-point y-offset z-offset tool-offset, with the meaning they have in
xyzac-trt-kins; trunnion_kins.compensate (bit, in, at first true): false gives the nominal kinematics, to be changed with
the machine off; trunnion_kins.outside (bit, out): the tilt has left the measured range, the errors of its end are held.
motion.switchkins-type: 0 tool centre point, 1 identity.
""";
license "GPL";
author "trunnion";
option singleton yes;
option extra_setup yes;
pin out bit loaded = 1 "true once the component is there";
;;
#include <hal.h>
#include <kinematics.h>
#include <rtapi_math.h>

/* Machine: Middle-size trunnion, serial 0001, model f24e3ef3f75e35d7, 2026-11-23. Lengths mm, angles of errors rad, of axes degrees. */
static const double tilt_sense = 1;
static const double turn_sense = 1;
static const double turn_axis[2] = {
  0, 0
};
static const double tilt_axis[2] = {
  0, 0
};
static const double largest_turn_change = 0.1;
static const double tilt_low = -90.25;
static const double tilt_step = 22.625;
#define tilt_count 7
#define turn_count 12
static const double error_map[tilt_count][turn_count][6] = {
{{0.001984919611, -0.004815770848, 0.00422398888, 1.8874766e-05, -1.2606464e-05, 1.4367288e-05},
 {0.00250833174, -0.0040668983919999995, 0.005365056521, 1.8436794e-05, -8.286043e-06, 1.0794429e-05},
 {0.0030317533549999998, -0.003771417688, 0.0066975448109999995, 1.7295676e-05, -3.9656379999999996e-06, 7.221554e-06},
 {0.003414928711, -0.003844056485, 0.007794981831, 1.5756484e-05, -8.02898e-07, 4.6060139999999996e-06},
 {0.003555179291, -0.003931317665, 0.008222282451999999, 1.4232038e-05, 3.54731e-07, 3.648646e-06},
 {0.003414923502, -0.003843998435, 0.007794946933, 1.3130608e-05, -8.02932e-07, 4.605983e-06},
 {0.0030317481519999997, -0.003771586415, 0.006697606514, 1.2747447999999999e-05, -3.965692e-06, 7.221508e-06},
 {0.002508331732, -0.004066476168, 0.0053648806, 1.3185186e-05, -8.286098999999999e-06, 1.0794386e-05},
 {0.001984924822, -0.00481592884, 0.004224069171, 1.4326579e-05, -1.2606507e-05, 1.436726e-05},
 {0.001601768497, -0.005652856505, 0.003510647776, 1.5865729e-05, -1.5769266e-05, 1.6982781e-05},
 {0.001461522217, -0.006020013251, 0.003275189178, 1.739026e-05, -1.692691e-05, 1.7940131e-05},
 {0.001601763291, -0.005652925291, 0.003510664087, 1.8491563e-05, -1.5769244e-05, 1.6982794e-05}},
{{0.001482134082, -0.003182176669, 0.002673146826, 1.4387052e-05, -1.1391413e-05, 9.66638e-06},
 {0.002005553861, -0.002930161913, 0.004015270786, 1.4141783e-05, -6.0256849999999996e-06, 8.031272e-06},
 {0.002528983732, -0.003170547508, 0.005359521709, 1.3334307999999999e-05, -6.599659999999999e-07, 6.396148e-06},
 {0.002912165519, -0.003660326282, 0.00634493337, 1.2180436e-05, 3.268004e-06, 5.19914e-06},
 {0.003052418534, -0.003905489535, 0.006705898654, 1.0989663999999999e-05, 4.705734e-06, 4.760993e-06},
 {0.00291216031, -0.003660259507, 0.00634492329, 1.0080895e-05, 3.267986e-06, 5.199117e-06},
 {0.002528978529, -0.003170727354, 0.005359513325, 9.697736e-06, -6.59996e-07, 6.396116e-06},
 {0.002005553851, -0.002929704267, 0.004015270533, 9.942823e-06, -6.025718e-06, 8.031247e-06},
 {0.001482139293, -0.0031823532209999997, 0.002673159736, 1.0750521e-05, -1.139144e-05, 9.666369999999999e-06},
 {0.001098977755, -0.003680397305, 0.001692014593, 1.1904357e-05, -1.531942e-05, 1.0863353e-05},
 {0.000958729649, -0.0039287445629999996, 0.001333170182, 1.3095192e-05, -1.6757156e-05, 1.1301478e-05},
 {0.001098972549, -0.003680467373, 0.0016920033789999999, 1.4003856999999999e-05, -1.5319404999999998e-05, 1.0863355e-05}},
{{0.000979349736, -0.001520491904, 0.001327793893, 9.895111999999999e-06, -9.342254e-06, 4.7092239999999996e-06},
 {0.00150277624, -0.00180410431, 0.002663422065, 9.84256e-06, -3.761111e-06, 5.263904e-06},
 {0.002026211902, -0.002542991506, 0.003811626111, 9.368735999999999e-06, 1.8200289999999999e-06, 5.81857e-06},
 {0.002409397331, -0.003374037455, 0.0045327217659999995, 8.600186e-06, 5.905707e-06, 6.2246e-06},
 {0.002549651554, -0.003739143272, 0.0047715756969999995, 7.743086e-06, 7.401167e-06, 6.373209e-06},
 {0.002409392123, -0.003373972115, 0.004532737843, 7.026979e-06, 5.905702e-06, 6.224584e-06},
 {0.002026206698, -0.002543154373, 0.003811548752, 6.6438199999999995e-06, 1.820019e-06, 5.8185499999999995e-06},
 {0.0015027762309999999, -0.001803681668, 0.002663597452, 6.696248e-06, -3.761127e-06, 5.263893e-06},
 {0.000979354946, -0.001520659425, 0.001327737659, 7.170238e-06, -9.34227e-06, 4.7092239999999996e-06},
 {0.000596187888, -0.001602957211, 0.000230643101, 7.938745e-06, -1.3427947e-05, 4.303168e-06},
 {0.000455937636, -0.001694148723, -0.000196067614, 8.79588e-06, -1.4923404e-05, 4.154536e-06},
 {0.000596182682, -0.0016030178979999999, 0.000230605899, 9.511911e-06, -1.3427935999999999e-05, 4.303163e-06}},
{{0.000476568668, -0.000102687002, 0.000371464763, 5.780243e-06, -6.8121599999999995e-06, 2.14376e-07},
 {0.00099999872, -0.000878336379, 0.001495271504, 5.920409e-06, -1.8736049999999999e-06, 2.873611e-06},
 {0.001523436395, -0.002002144645, 0.002270911863, 5.780237e-06, 3.064954e-06, 5.532834e-06},
 {0.001906622319, -0.003046706727, 0.00261683245, 5.397012e-06, 6.680235e-06, 7.4795079999999995e-06},
 {0.002046876518, -0.003475629243, 0.0026968535799999998, 4.873587e-06, 8.003523e-06, 8.192034e-06},
 {0.00190661711, -0.003046652634, 0.0026168720859999998, 4.350139e-06, 6.680239e-06, 7.479498e-06},
 {0.00152343119, -0.002002265152, 0.002270777339, 3.966977e-06, 3.064955e-06, 5.532822e-06},
 {0.000999998713, -0.000878013407, 0.001495595698, 3.826744e-06, -1.873611e-06, 2.873608e-06},
 {0.000476573878, -0.00010281955299999999, 0.000371348329, 3.9670249999999995e-06, -6.812171e-06, 2.14381e-07},
 {9.3403245e-05, 0.000243288058, -0.000673042087, 4.350207e-06, -1.0427442e-05, -1.732318e-06},
 {-4.6848521e-05, 0.00032327399899999997, -0.001102022531, 4.87364e-06, -1.1750718e-05, -2.4448649999999998e-06},
 {9.3398039e-05, 0.000243246008, -0.000673099813, 5.397038e-06, -1.0427433e-05, -1.732325e-06}},
{{-2.6209472e-05, 0.0008074579479999999, -4.1588536e-05, 2.42374e-06, -4.279706e-06, -3.1124959999999997e-06},
 {0.00049722113, -0.000340752938, 0.000697293292, 2.756612e-06, -7.44453e-07, 1.2416759999999999e-06},
 {0.001020658236, -0.001676378194, 0.000980895218, 2.950092e-06, 2.790809e-06, 5.595839e-06},
 {0.00140384303, -0.002773558511, 0.000898356877, 2.952197e-06, 5.37881e-06, 8.7833e-06},
 {0.001544096666, -0.003200228985, 0.000807218979, 2.762448e-06, 6.326089e-06, 9.949988e-06},
 {0.001403837822, -0.002773523733, 0.000898413938, 2.431658e-06, 5.378818e-06, 8.783294e-06},
 {0.001020653031, -0.001676437429, 0.000980724307, 2.048489e-06, 2.790817e-06, 5.595833e-06},
 {0.000497221124, -0.00034057915, 0.0006977165929999999, 1.715596e-06, -7.44454e-07, 1.2416759999999999e-06},
 {-2.6204262e-05, 0.000807380844, -4.1746885e-05, 1.522178e-06, -4.279716e-06, -3.112491e-06},
 {-0.00040937601, 0.001528582253, -0.000872562714, 1.520046e-06, -6.867698e-06, -6.29997e-06},
 {-0.000549628335, 0.00176742543, -0.001237735966, 1.709786e-06, -7.814959e-06, -7.4666729999999995e-06},
 {-0.000409381216, 0.0015285653449999999, -0.000872632336, 2.040544e-06, -6.867688e-06, -6.299976e-06}},
{{-0.000528986178, 0.001347709932, -0.000164279606, -5.55683e-07, -1.580872e-06, -5.392898e-06},
 {-5.556549e-06, 3.456493e-06, 7.6097096e-05, -3.0114e-08, 7.629e-09, -1.3186e-08},
 {0.000517878996, -0.001338658248, -0.00017592846499999999, 4.97017e-07, 1.596142e-06, 5.366521e-06},
 {0.000901062275, -0.002319787546, -0.000674229864, 8.84458e-07, 2.759026e-06, 9.304736e-06},
 {0.0010413152779999999, -0.002678614268, -0.000922513362, 1.02839e-06, 3.184679e-06, 1.0746221e-05},
 {0.000901057067, -0.002319777175, -0.000674164075, 8.902529999999999e-07, 2.759037e-06, 9.304734e-06},
 {0.000517873791, -0.001338646805, -0.0001761093, 5.07069e-07, 1.596153e-06, 5.366519e-06},
 {-5.556555e-06, 3.45451e-06, 7.6554736e-05, -1.8483e-08, 7.629e-09, -1.3186e-08},
 {-0.000528980968, 0.001347700044, -0.00016445518299999998, -5.45588e-07, -1.580882e-06, -5.3928959999999995e-06},
 {-0.000912152376, 0.002333119861, -0.000653980475, -9.33019e-07, -2.743742e-06, -9.331121e-06},
 {-0.001052404656, 0.00269410076, -0.000899210385, -1.076967e-06, -3.169371e-06, -1.0772613e-05},
 {-0.000912157583, 0.002333130822, -0.000654051522, -9.38856e-07, -2.743731e-06, -9.331122e-06}},
{{-0.001031761929, 0.001682299945, -0.000264500258, -3.539312e-06, 1.368577e-06, -6.845928e-06},
 {-0.000508334304, 0.000349815683, -0.000559991384, -2.821055e-06, 7.63926e-07, -1.272261e-06},
 {1.5099102e-05, -0.000791235356, -0.001308872055, -1.960275e-06, 1.59288e-07, 4.301407e-06},
 {0.00039828073, -0.001504539449, -0.002146032578, -1.187495e-06, -2.83326e-07, 8.381616e-06},
 {0.000538533109, -0.001740004528, -0.002513124547, -7.0988e-07, -4.45327e-07, 9.875077e-06},
 {0.000398275521, -0.0015045548899999999, -0.002145968064, -6.55366e-07, -2.83316e-07, 8.381618e-06},
 {1.5093897e-05, -0.0007911547689999999, -0.001309034562, -1.038566e-06, 1.59298e-07, 4.301409e-06},
 {-0.00050833431, 0.00034963816699999997, -0.00055956983, -1.756776e-06, 7.63925e-07, -1.272261e-06},
 {-0.00103175672, 0.00168235862, -0.000264665626, -2.617561e-06, 1.368566e-06, -6.845931e-06},
 {-0.001414926747, 0.002779703992, -0.000337066958, -3.390281e-06, 1.8112059999999999e-06, -1.092614e-05},
 {-0.001555178539, 0.00320704416, -0.00042438381399999997, -3.867912e-06, 1.973231e-06, -1.2419598e-05},
 {-0.001414931954, 0.002779741346, -0.000337128611, -3.922452e-06, 1.811217e-06, -1.0926137e-05}}
};
static const double linear_low[3] = {
  0, 0, 0
};
static const double linear_step[3] = {
  1, 1, 1
};
static const int linear_count[3] = {
  0, 0, 0
};
static const int linear_first[3] = {
  0, 0, 0
};
static const double linear_splines[] = {
  0, 0, 0, 0, 0, 0, 0, 0, 0
};

static int are_not_xyzac(const char *s) {
    const char *wanted = "XYZAC";
    int i;
    for (i = 0; i < 5; ++i)
        if (s[i] != wanted[i] && s[i] != wanted[i] + ('a' - 'A')) return 1;
    return s[5] != 0;
}

static char *coordinates = "XYZAC";
RTAPI_MP_STRING(coordinates, "Axis letters in order of joints; XYZAC");

static struct {
    hal_float_t *x_rot_point, *y_rot_point, *z_rot_point, *y_offset, *z_offset, *tool_offset;
    hal_bit_t *compensate, *outside;
} *pins;
static int switched_to; /* 0 tool centre point, 1 identity */

#define DEGREE 0.017453292519943295769
#define TURNS 0.017452406437283512820 /* sin 1 deg: how much C is held back where it can do little */

EXTRA_SETUP() {
    int bad = 0;
    (void)__comp_inst; (void)prefix; (void)extra_arg;
    if (are_not_xyzac(coordinates)) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_kins: coordinates=%s: XYZAC is wanted\n", coordinates);
        return -1;
    }
    pins = hal_malloc(sizeof *pins);
    if (!pins) return -1;
    bad |= hal_pin_float_newf(HAL_IN, &pins->x_rot_point, comp_id, "trunnion_kins.x-rot-point");
    bad |= hal_pin_float_newf(HAL_IN, &pins->y_rot_point, comp_id, "trunnion_kins.y-rot-point");
    bad |= hal_pin_float_newf(HAL_IN, &pins->z_rot_point, comp_id, "trunnion_kins.z-rot-point");
    bad |= hal_pin_float_newf(HAL_IN, &pins->y_offset, comp_id, "trunnion_kins.y-offset");
    bad |= hal_pin_float_newf(HAL_IN, &pins->z_offset, comp_id, "trunnion_kins.z-offset");
    bad |= hal_pin_float_newf(HAL_IN, &pins->tool_offset, comp_id, "trunnion_kins.tool-offset");
    bad |= hal_pin_bit_newf(HAL_IN, &pins->compensate, comp_id, "trunnion_kins.compensate");
    bad |= hal_pin_bit_newf(HAL_OUT, &pins->outside, comp_id, "trunnion_kins.outside");
    if (bad) return -1;
    *pins->x_rot_point = turn_axis[0];
    *pins->y_rot_point = turn_axis[1];
    *pins->z_rot_point = tilt_axis[1];
    *pins->y_offset = tilt_axis[0] - turn_axis[1];
    *pins->z_offset = 0;
    *pins->tool_offset = 0;
    *pins->compensate = 1;
    *pins->outside = 0;
    return 0;
}

/* The four cubic B-splines over a cell, u from 0 to 1 through it. */
static void splines(double u, double b[4]) {
    const double w = 1 - u;
    b[0] = w * w * w / 6;
    b[1] = (4 - 6 * u * u + 3 * u * u * u) / 6;
    b[2] = (4 - 6 * w * w + 3 * w * w * w) / 6;
    b[3] = u * u * u / 6;
}

/* Along a line of count - 3 cells: the first spline that matters and the place in its cell, ends held. */
static int cell_of(double x, double low, double step, int count, double *u) {
    double t = (x - low) / step;
    int cell;
    if (!(t > 0)) t = 0; /* also for what is no number */
    if (t > count - 3) t = count - 3;
    cell = (int)t;
    if (cell > count - 4) cell = count - 4;
    *u = t - cell;
    return cell;
}

/* The table's pose error (Dx Dy Dz Da Db Dc; mm, rad) at R's origin, plus what X, Y and Z add at the tip p of R. */
static void error_at(double tilt_deg, double turn_deg, const double p[3], double e[6]) {
    double u, v, bt[4], bc[4], t;
    int i, j, k, n, cell, first;
    for (k = 0; k < 6; ++k) e[k] = 0;
    cell = cell_of(tilt_deg, tilt_low, tilt_step, tilt_count, &u);
    splines(u, bt);
    t = turn_deg / 360;
    t = (t - floor(t)) * turn_count;
    first = (int)t;
    if (!(first >= 0 && first < turn_count)) first = 0, t = 0;
    v = t - first;
    splines(v, bc);
    for (i = 0; i < 4; ++i)
        for (j = 0; j < 4; ++j) {
            const double *c = error_map[cell + i][(first + j) % turn_count];
            for (k = 0; k < 6; ++k) e[k] += bt[i] * bc[j] * c[k];
        }
    for (n = 0; n < 3; ++n) {
        if (!linear_count[n]) continue;
        cell = cell_of(p[n], linear_low[n], linear_step[n], linear_count[n], &u);
        splines(u, bt);
        for (i = 0; i < 4; ++i) {
            const double *c = linear_splines + 9 * (linear_first[n] + cell + i);
            for (k = 0; k < 3; ++k) {
                e[k] += bt[i] * (c[k] + c[6 + k]); /* a deviation of the tip alone is a shift */
                e[3 + k] += bt[i] * c[3 + k];
            }
        }
    }
}

/* v turned by Rx(a), Ry(b), Rz(c), the last one first. */
static void turned(double a, double b, double c, double v[3]) {
    double s, t, x, y;
    s = sin(c), t = cos(c), x = v[0], y = v[1];
    v[0] = t * x - s * y, v[1] = s * x + t * y;
    s = sin(b), t = cos(b), x = v[0], y = v[2];
    v[0] = t * x + s * y, v[2] = t * y - s * x;
    s = sin(a), t = cos(a), x = v[1], y = v[2];
    v[1] = t * x - s * y, v[2] = s * x + t * y;
}

/* Nominal table: where the point w of the work frame stands with the axes at a, c (rad, right-handed). */
static void on_table(const double w[3], double a, double c, double q[3]) {
    const double s = sin(c), t = cos(c), sa = sin(a), ca = cos(a);
    const double x = w[0] - *pins->x_rot_point, y = w[1] - *pins->y_rot_point, z = w[2] - *pins->z_rot_point;
    const double qy = s * x + t * y - *pins->y_offset, qz = z - *pins->z_offset;
    q[0] = t * x - s * y + *pins->x_rot_point;
    q[1] = ca * qy - sa * qz + *pins->y_offset + *pins->y_rot_point;
    q[2] = sa * qy + ca * qz + *pins->z_offset + *pins->z_rot_point;
}

/* How far R's origin stands from the control's zero. */
static void origin_of_r(double o[3]) {
    o[0] = *pins->x_rot_point - turn_axis[0];
    o[1] = *pins->y_rot_point - turn_axis[1];
    o[2] = *pins->z_rot_point + *pins->z_offset - tilt_axis[1];
}

static void inverse(const double w[3], double tilt_deg, double turn_deg, double joint[5]) {
    const double cap = largest_turn_change * DEGREE;
    double o[3], q[3], p[3], e[6], u[3], v[3], a, c, a0, c0, turn = 0, sa;
    int step, k;
    a = a0 = tilt_sense * tilt_deg * DEGREE;
    c = c0 = turn_sense * turn_deg * DEGREE;
    origin_of_r(o);
    on_table(w, a, c, q);
    if (*pins->compensate) {
        /* the tool's axis as the work sees it */
        u[0] = sin(c) * sin(a), u[1] = cos(c) * sin(a), u[2] = cos(a);
        for (step = 0; step < 4; ++step) {
            double x, y, change;
            for (k = 0; k < 3; ++k) p[k] = q[k] - o[k];
            error_at(tilt_sense * a / DEGREE, turn_sense * c / DEGREE, p, e);
            for (k = 0; k < 3; ++k) v[k] = u[k];
            turned(0, 0, c, v);
            turned(a, 0, 0, v);
            turned(e[3], e[4], e[5], v);
            sa = sin(a);
            change = (v[0] * sa - TURNS * TURNS * turn) / (sa * sa + TURNS * TURNS);
            turn += change;
            x = turn / cap;
            y = x * x * x * x;
            c = c0 + (cap > 0 ? turn / pow(1 + y * y, 0.125) : 0);
            a += v[1];
            on_table(w, a, c, q);
        }
        for (k = 0; k < 3; ++k) p[k] = q[k] - o[k];
        for (step = 0; step < 3; ++step) {
            error_at(tilt_sense * a / DEGREE, turn_sense * c / DEGREE, p, e);
            for (k = 0; k < 3; ++k) p[k] = q[k] - o[k];
            turned(e[3], e[4], e[5], p);
            for (k = 0; k < 3; ++k) p[k] += e[k];
        }
        for (k = 0; k < 3; ++k) q[k] = p[k] + o[k];
    }
    joint[0] = q[0];
    joint[1] = q[1];
    joint[2] = q[2] + *pins->tool_offset;
    joint[3] = tilt_deg + tilt_sense * (a - a0) / DEGREE;
    joint[4] = turn_deg + turn_sense * (c - c0) / DEGREE;
}

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags,
                      KINEMATICS_FORWARD_FLAGS *fflags) {
    double w[3];
    (void)iflags; (void)fflags;
    w[0] = world->tran.x, w[1] = world->tran.y, w[2] = world->tran.z;
    if (switched_to == 1) {
        joint[0] = w[0], joint[1] = w[1], joint[2] = w[2], joint[3] = world->a, joint[4] = world->c;
        return 0;
    }
    inverse(w, world->a, world->c, joint);
    *pins->outside = world->a < tilt_low - 1e-6 || world->a > tilt_low + (tilt_count - 3) * tilt_step + 1e-6;
    return 0;
}

/* The world position whose inverse is `joint`: corrected by what its inverse misses, until nothing is left. */
int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags,
                      KINEMATICS_INVERSE_FLAGS *iflags) {
    double w[3], reached[5], tilt = joint[3], turn = joint[4];
    int step;
    (void)fflags; (void)iflags;
    w[0] = joint[0], w[1] = joint[1], w[2] = joint[2];
    if (switched_to == 0) {
        for (step = 0; step < 12; ++step) {
            double x, y, z, s, t, left;
            inverse(w, tilt, turn, reached);
            tilt += joint[3] - reached[3];
            turn += joint[4] - reached[4];
            x = joint[0] - reached[0], y = joint[1] - reached[1], z = joint[2] - reached[2];
            left = fabs(x) + fabs(y) + fabs(z) + fabs(joint[3] - reached[3]) + fabs(joint[4] - reached[4]);
            s = sin(tilt_sense * tilt * DEGREE), t = cos(tilt_sense * tilt * DEGREE);
            { const double yy = t * y + s * z; z = t * z - s * y; y = yy; }
            s = sin(turn_sense * turn * DEGREE), t = cos(turn_sense * turn * DEGREE);
            w[0] += t * x + s * y, w[1] += t * y - s * x, w[2] += z;
            if (left < 1e-10) break;
        }
    }
    world->tran.x = w[0], world->tran.y = w[1], world->tran.z = w[2];
    world->a = tilt, world->c = turn;
    world->b = world->u = world->v = world->w = 0;
    return 0;
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_BOTH; }
int kinematicsSwitchable(void) { return 1; }
int kinematicsSwitch(int new_type) {
    if (new_type != 0 && new_type != 1) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_kins: kinematics type %d: 0 or 1 is wanted\n", new_type);
        return -1;
    }
    switched_to = new_type;
    return 0;
}

EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsSwitchable);
EXPORT_SYMBOL(kinematicsSwitch);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsForward);
