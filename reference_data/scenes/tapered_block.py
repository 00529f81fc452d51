#!/usr/bin/env python3
"""Writes tapered_block.msh: 4 x 2 x 2 hexahedra in gmsh's ASCII format 4.1.

The block is 0.2 m long; its square section shrinks from 0.06 m to 0.03 m. Physical surfaces: "root" (x = 0) and
"tip" (x = 0.2).  Usage: ./tapered_block.py > tapered_block.msh
"""

NX, NY, NZ = 4, 2, 2


def tag(i, j, k):
    return 1 + i + (NX + 1) * (j + (NY + 1) * k)


def position(i, j, k):
    width = 0.06 - 0.03 * i / NX
    return 0.2 * i / NX, width * (j / NY - 0.5), width * (k / NZ - 0.5)


nodes = [(i, j, k) for k in range(NZ + 1) for j in range(NY + 1) for i in range(NX + 1)]
faces = {
    1: [[tag(0, j, k), tag(0, j, k + 1), tag(0, j + 1, k + 1), tag(0, j + 1, k)] for k in range(NZ) for j in range(NY)],
    2: [[tag(NX, j, k), tag(NX, j + 1, k), tag(NX, j + 1, k + 1), tag(NX, j, k + 1)]
        for k in range(NZ) for j in range(NY)],
}
cells = [[tag(i, j, k), tag(i + 1, j, k), tag(i + 1, j + 1, k), tag(i, j + 1, k),
          tag(i, j, k + 1), tag(i + 1, j, k + 1), tag(i + 1, j + 1, k + 1), tag(i, j + 1, k + 1)]
         for k in range(NZ) for j in range(NY) for i in range(NX)]

print('$MeshFormat\n4.1 0 8\n$EndMeshFormat')
print('$PhysicalNames\n3\n2 11 "root"\n2 12 "tip"\n3 13 "tissue"\n$EndPhysicalNames')
print('$Entities\n0 0 2 1')
print('1 0 -0.03 -0.03 0 0.03 0.03 1 11 0')
print('2 0.2 -0.015 -0.015 0.2 0.015 0.015 1 12 0')
print('1 0 -0.03 -0.03 0.2 0.03 0.03 1 13 2 1 2\n$EndEntities')
print(f'$Nodes\n1 {len(nodes)} 1 {len(nodes)}\n3 1 0 {len(nodes)}')
for node in nodes:
    print(tag(*node))
for node in nodes:
    print('%.17g %.17g %.17g' % position(*node))
print('$EndNodes')
total = len(cells) + sum(len(f) for f in faces.values())
print(f'$Elements\n3 {total} 1 {total}')
number = 0
for dimension, entity, kind, elements in [(2, 1, 3, faces[1]), (2, 2, 3, faces[2]), (3, 1, 5, cells)]:
    print(dimension, entity, kind, len(elements))
    for element in elements:
        number += 1
        print(number, *element)
print('$EndElements')
