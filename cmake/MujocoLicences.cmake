# The licences that lie beside a libmujoco: of the wheel, of a release, of an installed fricid.
function(fricid_mujoco_licences library licences_var)
  cmake_path(GET library PARENT_PATH folder)
  cmake_path(GET library FILENAME name)
  file(GLOB licences ${folder}/../*.dist-info/licenses/* ${folder}/../LICENSE* ${folder}/../THIRD_PARTY*
       ${folder}/../share/fricid/licences/${name}/*)
  set(${licences_var} "${licences}" PARENT_SCOPE)
endfunction()
