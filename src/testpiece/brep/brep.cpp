#include "testpiece/brep/brep.h"

#include <unistd.h>

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepTools.hxx>
#include <GProp_GProps.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <gp_Ax2.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>

namespace {

const std::string kCounted = "'cone frustum ";

/// A file of its own for OpenCASCADE, which writes only to files; gone at the end.
class ScratchFile {
 public:
  ScratchFile() {
    const char* folder = std::getenv("TMPDIR");
    path_ = std::string(folder != nullptr && *folder != '\0' ? folder : "/tmp") + "/trunnion-XXXXXX";
    const int file = mkstemp(path_.data());
    if (file < 0) throw std::runtime_error("no place for a scratch file in " + path_);
    close(file);
  }
  ~ScratchFile() { std::remove(path_.c_str()); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const char* path() const { return path_.c_str(); }

 private:
  std::string path_;
};

gp_Pnt point(const double (&p)[3]) { return {p[0], p[1], p[2]}; }
gp_Dir direction(const double (&d)[3]) { return {d[0], d[1], d[2]}; }

TopoDS_Shape solid(const TrunnionBrepFrustum& f) {
  const gp_Ax2 base(point(f.base_center_mm), direction(f.axis), direction(f.zero));
  const double radius = f.base_diameter_mm / 2, top = radius - f.height_mm * std::tan(f.half_angle_rad);
  const TopoDS_Shape frustum = f.half_angle_rad < 1e-9 ? BRepPrimAPI_MakeCylinder(base, radius, f.height_mm).Shape()
                                                       : BRepPrimAPI_MakeCone(base, radius, top, f.height_mm).Shape();
  const gp_Vec down = -f.block_height_mm * gp_Vec(base.Direction());
  const gp_Vec aside = -0.5 * f.block_side_mm * (gp_Vec(base.XDirection()) + gp_Vec(base.YDirection()));
  const gp_Ax2 corner(base.Location().Translated(down + aside), base.Direction(), base.XDirection());
  const TopoDS_Shape block = BRepPrimAPI_MakeBox(corner, f.block_side_mm, f.block_side_mm, f.block_height_mm).Shape();
  BRepAlgoAPI_Fuse fused(frustum, block);
  if (!fused.IsDone()) throw std::runtime_error("frustum and block do not unite");
  fused.SimplifyResult();
  TopExp_Explorer solids(fused.Shape(), TopAbs_SOLID);
  if (!solids.More()) throw std::runtime_error("frustum and block make no solid");
  return solids.Current();
}

/// The flank as a face of the solid, asked by its own parameters: u turns about the axis, v runs along the rulings.
class Flank {
 public:
  explicit Flank(const TrunnionBrepFrustum& f) : solid_(solid(f)) {
    const gp_Dir axis = direction(f.axis), zero = direction(f.zero);
    for (TopExp_Explorer at(solid_, TopAbs_FACE); at.More(); at.Next()) {
      const TopoDS_Face face = TopoDS::Face(at.Current());
      const BRepAdaptor_Surface surface(face);
      const bool cone = surface.GetType() == GeomAbs_Cone;
      if (!cone && surface.GetType() != GeomAbs_Cylinder) continue;
      const gp_Ax3 place = cone ? surface.Cone().Position() : surface.Cylinder().Position();
      double u_low = 0, u_high = 0, v_low = 0, v_high = 0;
      BRepTools::UVBounds(face, u_low, u_high, v_low, v_high);
      const auto height = [&](double v) { return gp_Vec(point(f.base_center_mm), surface.Value(u_low, v)) * axis; };
      base_v_ = height(v_low) < height(v_high) ? v_low : v_high;
      along_ = height(v_low) < height(v_high) ? 1 : -1;
      // u is counted about the surface's own axis from its own x.
      turn_ = (place.Direction() * axis > 0) == static_cast<bool>(place.Direct()) ? 1 : -1;
      zero_u_ = turn_ * place.XDirection().AngleWithRef(zero, axis);
      outward_ = face.Orientation() == TopAbs_REVERSED ? -1 : 1;
      surface_ = surface;
      return;
    }
    throw std::runtime_error("the solid has no flank");
  }

  TrunnionBrepRuling at(double phi_rad) const {
    gp_Pnt on;
    gp_Vec by_u, by_v;
    surface_.D1(zero_u_ + turn_ * phi_rad, base_v_, on, by_u, by_v);
    const gp_Vec normal = outward_ * by_u.Crossed(by_v).Normalized(), along = along_ * by_v.Normalized();
    return {{on.X(), on.Y(), on.Z()}, {normal.X(), normal.Y(), normal.Z()}, {along.X(), along.Y(), along.Z()}};
  }

 private:
  TopoDS_Shape solid_;
  BRepAdaptor_Surface surface_;
  double base_v_ = 0, zero_u_ = 0;
  double along_ = 1, turn_ = 1, outward_ = 1;
};

void quiet() { Message::DefaultMessenger()->ChangePrinters().Clear(); }

std::string step_text(const TopoDS_Shape& shape) {
  STEPControl_Controller::Init();  // before the schema is chosen, or the choice is lost
  Interface_Static::SetCVal("write.step.schema", "AP242DIS");
  Interface_Static::SetCVal("write.step.unit", "MM");
  Interface_Static::SetCVal("write.step.product.name", "cone frustum");
  STEPControl_Writer writer;
  if (writer.Transfer(shape, STEPControl_ManifoldSolidBrep) != IFSelect_RetDone)
    throw std::runtime_error("the solid cannot be told in STEP");
  APIHeaderSection_MakeHeader header(writer.Model());
  header.SetName(new TCollection_HAsciiString("cone frustum"));
  header.SetTimeStamp(new TCollection_HAsciiString("2000-01-01T00:00:00"));
  header.SetOriginatingSystem(new TCollection_HAsciiString("trunnion"));
  const ScratchFile scratch;
  if (writer.Write(scratch.path()) != IFSelect_RetDone) throw std::runtime_error("the STEP text cannot be written");
  std::ifstream file(scratch.path(), std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  // OpenCASCADE numbers the products of a process; a product's name shall not depend on what was made before it.
  for (std::size_t at = 0; (at = text.find(kCounted, at)) != std::string::npos; at += kCounted.size() - 1) {
    const std::size_t number = at + kCounted.size(), end = text.find_first_not_of("0123456789", number);
    if (end > number) text.erase(number - 1, end - number + 1);
  }
  return text;
}

/// Runs `work`; whatever it throws becomes a line.
template <class Work>
int guarded(char* problem, std::size_t size, Work work) {
  std::string text;
  try {
    quiet();
    work();
    return 0;
  } catch (const Standard_Failure& e) {
    text = std::string("OpenCASCADE: ") + e.GetMessageString();
  } catch (const std::exception& e) {
    text = e.what();
  }
  if (size > 0) {
    const std::size_t count = std::min(text.size(), size - 1);
    std::copy_n(text.data(), count, problem);
    problem[count] = '\0';
  }
  return 1;
}

}  // namespace

extern "C" int trunnion_brep_step(const TrunnionBrepFrustum* frustum, TrunnionBrepWrite write, void* target,
                                  char* problem, std::size_t problem_size) {
  return guarded(problem, problem_size, [&] {
    const std::string text = step_text(solid(*frustum));
    write(target, text.data(), text.size());
  });
}

extern "C" int trunnion_brep_measure(const char* text, std::size_t size, double* volume_mm3, int* faces,
                                     double* semi_angle_rad, char* problem, std::size_t problem_size) {
  return guarded(problem, problem_size, [&] {
    STEPControl_Reader reader;
    std::istringstream stream(std::string(text, size));
    if (reader.ReadStream("piece.step", stream) != IFSelect_RetDone) throw std::runtime_error("the text is no STEP");
    reader.TransferRoots();
    const TopoDS_Shape shape = reader.OneShape();
    GProp_GProps properties;
    BRepGProp::VolumeProperties(shape, properties);
    *volume_mm3 = properties.Mass();
    *faces = 0;
    *semi_angle_rad = 0;
    for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next()) {
      ++*faces;
      const BRepAdaptor_Surface surface(TopoDS::Face(at.Current()));
      if (surface.GetType() == GeomAbs_Cone) *semi_angle_rad = std::abs(surface.Cone().SemiAngle());
    }
  });
}

extern "C" void* trunnion_brep_flank_open(const TrunnionBrepFrustum* frustum, char* problem, std::size_t problem_size) {
  Flank* flank = nullptr;
  guarded(problem, problem_size, [&] { flank = new Flank(*frustum); });
  return flank;
}

extern "C" void trunnion_brep_flank_at(const void* flank, double phi_rad, TrunnionBrepRuling* ruling) {
  *ruling = static_cast<const Flank*>(flank)->at(phi_rad);
}

extern "C" void trunnion_brep_flank_close(void* flank) { delete static_cast<Flank*>(flank); }
