#include <gtest/gtest.h>

#include <BRep_Tool.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_ProgressRange.hxx>
#include <Poly_Triangulation.hxx>
#include <RWGltf_CafReader.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <cmath>
#include <fstream>

#include "testpiece/part_view.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

constexpr double kSingle_mm = 2e-5;  // 0.1 m in the single precision of glTF

/// The triangulations of a GLB as OpenCASCADE's reader makes them, in W and mm.
std::vector<opencascade::handle<Poly_Triangulation>> read_back(const std::string& glb, const std::string& name) {
  const std::string path = ::testing::TempDir() + name;
  std::ofstream(path, std::ios::binary) << glb;
  Message::DefaultMessenger()->ChangePrinters().Clear();
  RWGltf_CafReader reader;
  reader.SetSystemLengthUnit(1e-3);
  reader.SetSystemCoordinateSystem(RWMesh_CoordinateSystem_Zup);
  EXPECT_TRUE(reader.Perform(path.c_str(), Message_ProgressRange()));
  std::vector<opencascade::handle<Poly_Triangulation>> found;
  for (TopExp_Explorer at(reader.SingleShape(), TopAbs_FACE); at.More(); at.Next()) {
    TopLoc_Location place;
    found.push_back(BRep_Tool::Triangulation(TopoDS::Face(at.Current()), place));
    EXPECT_TRUE(place.IsIdentity());
  }
  return found;
}

TEST(PartViewInAReader, StandsInTheWorkpieceWithEveryVertexOnTheCone) {
  TestPiece piece = usual_piece(15, 10);
  piece.points = 72;
  piece.heights = {Length(), Length::millimetres(10), Length::millimetres(20)};
  const SurfaceGrid surface = evaluated_surface(piece);
  const std::vector<double> deviation(surface.points.size(), 4e-3);
  const Eigen::Isometry3d cone_from_w = w_from_cone(piece.cone).inverse(Eigen::Isometry);
  for (const double magnification : {0.0, 250.0}) {
    const auto meshes = read_back(part_glb(piece, surface, deviation, 5, magnification), "part.glb");
    ASSERT_EQ(meshes.size(), 2U);  // the part and the colour bar
    for (const auto& mesh : meshes) ASSERT_FALSE(mesh.IsNull());
    EXPECT_EQ(meshes[0]->NbTriangles(), 2 * 72 * 2 + 2 * 72);
    ASSERT_GE(meshes[0]->NbNodes(), 3 * 72);
    for (int i = 1; i <= 3 * 72; ++i) {
      const gp_Pnt node = meshes[0]->Node(i);
      const Eigen::Vector3d p = cone_from_w * Eigen::Vector3d(node.X(), node.Y(), node.Z());
      // The distance from the flank, along its normal.
      const double t = piece.cone.half_angle.in_radians();
      const double off = (p.head<2>().norm() - 40) * std::cos(t) + p.z() * std::sin(t);
      EXPECT_NEAR(off, magnification * 4e-3, kSingle_mm) << i;
    }
  }
}

}  // namespace
}  // namespace trunnion
