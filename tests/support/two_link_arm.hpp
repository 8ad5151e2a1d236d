// A small robot and the shortest scene for it.
#pragma once

namespace fricid {

/// Two revolute joints in a vertical plane, and a fixed tool frame.
inline constexpr char kArmUrdf[] = R"(<?xml version="1.0"?>
<robot name="two_link">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.2 0 0"/>
      <mass value="4"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial>
      <origin xyz="0.15 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.005" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>
    </inertial>
  </link>
  <link name="flange"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="4" effort="80"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-2.5" upper="2.5" velocity="5" effort="40"/>
  </joint>
  <joint name="flange_joint" type="fixed">
    <parent link="lower"/><child link="flange"/><origin xyz="0.3 0 0"/>
  </joint>
</robot>
)";

/// The shortest scene for it.
inline constexpr char kScene[] = R"(
[robot]
urdf = "arm.urdf"
mjcf = "arm.xml"

[friction]
[[friction.law]]
law = "coulomb_viscous"
Fc = 3
Fv = [1.0, 0.5]
v0 = 0.01
)";

}  // namespace fricid
