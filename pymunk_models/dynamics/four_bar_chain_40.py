"""Chain of 40 parallel four-bars in free swing, scene four-bar-chain-40 of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('tip')

Source: the benchmark N-four-bar of the IFToMM library of computational benchmark problems.

Parameters (SI):

    bodies.bar0.points.A.x = 0 m              place of A on bar0
    bodies.bar0.points.A.y = 0 m              place of A on bar0
    bodies.bar0.points.B.x = 1 m              place of B on bar0
    bodies.bar0.points.B.y = 0 m              place of B on bar0
    bodies.bar0.mass = 1 kg                   mass of bar0
    bodies.bar1.points.A.x = 0 m              place of A on bar1
    bodies.bar1.points.A.y = 0 m              place of A on bar1
    bodies.bar1.points.B.x = 1 m              place of B on bar1
    bodies.bar1.points.B.y = 0 m              place of B on bar1
    bodies.bar1.mass = 1 kg                   mass of bar1
    bodies.bar10.points.A.x = 0 m             place of A on bar10
    bodies.bar10.points.A.y = 0 m             place of A on bar10
    bodies.bar10.points.B.x = 1 m             place of B on bar10
    bodies.bar10.points.B.y = 0 m             place of B on bar10
    bodies.bar10.mass = 1 kg                  mass of bar10
    bodies.bar11.points.A.x = 0 m             place of A on bar11
    bodies.bar11.points.A.y = 0 m             place of A on bar11
    bodies.bar11.points.B.x = 1 m             place of B on bar11
    bodies.bar11.points.B.y = 0 m             place of B on bar11
    bodies.bar11.mass = 1 kg                  mass of bar11
    bodies.bar12.points.A.x = 0 m             place of A on bar12
    bodies.bar12.points.A.y = 0 m             place of A on bar12
    bodies.bar12.points.B.x = 1 m             place of B on bar12
    bodies.bar12.points.B.y = 0 m             place of B on bar12
    bodies.bar12.mass = 1 kg                  mass of bar12
    bodies.bar13.points.A.x = 0 m             place of A on bar13
    bodies.bar13.points.A.y = 0 m             place of A on bar13
    bodies.bar13.points.B.x = 1 m             place of B on bar13
    bodies.bar13.points.B.y = 0 m             place of B on bar13
    bodies.bar13.mass = 1 kg                  mass of bar13
    bodies.bar14.points.A.x = 0 m             place of A on bar14
    bodies.bar14.points.A.y = 0 m             place of A on bar14
    bodies.bar14.points.B.x = 1 m             place of B on bar14
    bodies.bar14.points.B.y = 0 m             place of B on bar14
    bodies.bar14.mass = 1 kg                  mass of bar14
    bodies.bar15.points.A.x = 0 m             place of A on bar15
    bodies.bar15.points.A.y = 0 m             place of A on bar15
    bodies.bar15.points.B.x = 1 m             place of B on bar15
    bodies.bar15.points.B.y = 0 m             place of B on bar15
    bodies.bar15.mass = 1 kg                  mass of bar15
    bodies.bar16.points.A.x = 0 m             place of A on bar16
    bodies.bar16.points.A.y = 0 m             place of A on bar16
    bodies.bar16.points.B.x = 1 m             place of B on bar16
    bodies.bar16.points.B.y = 0 m             place of B on bar16
    bodies.bar16.mass = 1 kg                  mass of bar16
    bodies.bar17.points.A.x = 0 m             place of A on bar17
    bodies.bar17.points.A.y = 0 m             place of A on bar17
    bodies.bar17.points.B.x = 1 m             place of B on bar17
    bodies.bar17.points.B.y = 0 m             place of B on bar17
    bodies.bar17.mass = 1 kg                  mass of bar17
    bodies.bar18.points.A.x = 0 m             place of A on bar18
    bodies.bar18.points.A.y = 0 m             place of A on bar18
    bodies.bar18.points.B.x = 1 m             place of B on bar18
    bodies.bar18.points.B.y = 0 m             place of B on bar18
    bodies.bar18.mass = 1 kg                  mass of bar18
    bodies.bar19.points.A.x = 0 m             place of A on bar19
    bodies.bar19.points.A.y = 0 m             place of A on bar19
    bodies.bar19.points.B.x = 1 m             place of B on bar19
    bodies.bar19.points.B.y = 0 m             place of B on bar19
    bodies.bar19.mass = 1 kg                  mass of bar19
    bodies.bar2.points.A.x = 0 m              place of A on bar2
    bodies.bar2.points.A.y = 0 m              place of A on bar2
    bodies.bar2.points.B.x = 1 m              place of B on bar2
    bodies.bar2.points.B.y = 0 m              place of B on bar2
    bodies.bar2.mass = 1 kg                   mass of bar2
    bodies.bar20.points.A.x = 0 m             place of A on bar20
    bodies.bar20.points.A.y = 0 m             place of A on bar20
    bodies.bar20.points.B.x = 1 m             place of B on bar20
    bodies.bar20.points.B.y = 0 m             place of B on bar20
    bodies.bar20.mass = 1 kg                  mass of bar20
    bodies.bar21.points.A.x = 0 m             place of A on bar21
    bodies.bar21.points.A.y = 0 m             place of A on bar21
    bodies.bar21.points.B.x = 1 m             place of B on bar21
    bodies.bar21.points.B.y = 0 m             place of B on bar21
    bodies.bar21.mass = 1 kg                  mass of bar21
    bodies.bar22.points.A.x = 0 m             place of A on bar22
    bodies.bar22.points.A.y = 0 m             place of A on bar22
    bodies.bar22.points.B.x = 1 m             place of B on bar22
    bodies.bar22.points.B.y = 0 m             place of B on bar22
    bodies.bar22.mass = 1 kg                  mass of bar22
    bodies.bar23.points.A.x = 0 m             place of A on bar23
    bodies.bar23.points.A.y = 0 m             place of A on bar23
    bodies.bar23.points.B.x = 1 m             place of B on bar23
    bodies.bar23.points.B.y = 0 m             place of B on bar23
    bodies.bar23.mass = 1 kg                  mass of bar23
    bodies.bar24.points.A.x = 0 m             place of A on bar24
    bodies.bar24.points.A.y = 0 m             place of A on bar24
    bodies.bar24.points.B.x = 1 m             place of B on bar24
    bodies.bar24.points.B.y = 0 m             place of B on bar24
    bodies.bar24.mass = 1 kg                  mass of bar24
    bodies.bar25.points.A.x = 0 m             place of A on bar25
    bodies.bar25.points.A.y = 0 m             place of A on bar25
    bodies.bar25.points.B.x = 1 m             place of B on bar25
    bodies.bar25.points.B.y = 0 m             place of B on bar25
    bodies.bar25.mass = 1 kg                  mass of bar25
    bodies.bar26.points.A.x = 0 m             place of A on bar26
    bodies.bar26.points.A.y = 0 m             place of A on bar26
    bodies.bar26.points.B.x = 1 m             place of B on bar26
    bodies.bar26.points.B.y = 0 m             place of B on bar26
    bodies.bar26.mass = 1 kg                  mass of bar26
    bodies.bar27.points.A.x = 0 m             place of A on bar27
    bodies.bar27.points.A.y = 0 m             place of A on bar27
    bodies.bar27.points.B.x = 1 m             place of B on bar27
    bodies.bar27.points.B.y = 0 m             place of B on bar27
    bodies.bar27.mass = 1 kg                  mass of bar27
    bodies.bar28.points.A.x = 0 m             place of A on bar28
    bodies.bar28.points.A.y = 0 m             place of A on bar28
    bodies.bar28.points.B.x = 1 m             place of B on bar28
    bodies.bar28.points.B.y = 0 m             place of B on bar28
    bodies.bar28.mass = 1 kg                  mass of bar28
    bodies.bar29.points.A.x = 0 m             place of A on bar29
    bodies.bar29.points.A.y = 0 m             place of A on bar29
    bodies.bar29.points.B.x = 1 m             place of B on bar29
    bodies.bar29.points.B.y = 0 m             place of B on bar29
    bodies.bar29.mass = 1 kg                  mass of bar29
    bodies.bar3.points.A.x = 0 m              place of A on bar3
    bodies.bar3.points.A.y = 0 m              place of A on bar3
    bodies.bar3.points.B.x = 1 m              place of B on bar3
    bodies.bar3.points.B.y = 0 m              place of B on bar3
    bodies.bar3.mass = 1 kg                   mass of bar3
    bodies.bar30.points.A.x = 0 m             place of A on bar30
    bodies.bar30.points.A.y = 0 m             place of A on bar30
    bodies.bar30.points.B.x = 1 m             place of B on bar30
    bodies.bar30.points.B.y = 0 m             place of B on bar30
    bodies.bar30.mass = 1 kg                  mass of bar30
    bodies.bar31.points.A.x = 0 m             place of A on bar31
    bodies.bar31.points.A.y = 0 m             place of A on bar31
    bodies.bar31.points.B.x = 1 m             place of B on bar31
    bodies.bar31.points.B.y = 0 m             place of B on bar31
    bodies.bar31.mass = 1 kg                  mass of bar31
    bodies.bar32.points.A.x = 0 m             place of A on bar32
    bodies.bar32.points.A.y = 0 m             place of A on bar32
    bodies.bar32.points.B.x = 1 m             place of B on bar32
    bodies.bar32.points.B.y = 0 m             place of B on bar32
    bodies.bar32.mass = 1 kg                  mass of bar32
    bodies.bar33.points.A.x = 0 m             place of A on bar33
    bodies.bar33.points.A.y = 0 m             place of A on bar33
    bodies.bar33.points.B.x = 1 m             place of B on bar33
    bodies.bar33.points.B.y = 0 m             place of B on bar33
    bodies.bar33.mass = 1 kg                  mass of bar33
    bodies.bar34.points.A.x = 0 m             place of A on bar34
    bodies.bar34.points.A.y = 0 m             place of A on bar34
    bodies.bar34.points.B.x = 1 m             place of B on bar34
    bodies.bar34.points.B.y = 0 m             place of B on bar34
    bodies.bar34.mass = 1 kg                  mass of bar34
    bodies.bar35.points.A.x = 0 m             place of A on bar35
    bodies.bar35.points.A.y = 0 m             place of A on bar35
    bodies.bar35.points.B.x = 1 m             place of B on bar35
    bodies.bar35.points.B.y = 0 m             place of B on bar35
    bodies.bar35.mass = 1 kg                  mass of bar35
    bodies.bar36.points.A.x = 0 m             place of A on bar36
    bodies.bar36.points.A.y = 0 m             place of A on bar36
    bodies.bar36.points.B.x = 1 m             place of B on bar36
    bodies.bar36.points.B.y = 0 m             place of B on bar36
    bodies.bar36.mass = 1 kg                  mass of bar36
    bodies.bar37.points.A.x = 0 m             place of A on bar37
    bodies.bar37.points.A.y = 0 m             place of A on bar37
    bodies.bar37.points.B.x = 1 m             place of B on bar37
    bodies.bar37.points.B.y = 0 m             place of B on bar37
    bodies.bar37.mass = 1 kg                  mass of bar37
    bodies.bar38.points.A.x = 0 m             place of A on bar38
    bodies.bar38.points.A.y = 0 m             place of A on bar38
    bodies.bar38.points.B.x = 1 m             place of B on bar38
    bodies.bar38.points.B.y = 0 m             place of B on bar38
    bodies.bar38.mass = 1 kg                  mass of bar38
    bodies.bar39.points.A.x = 0 m             place of A on bar39
    bodies.bar39.points.A.y = 0 m             place of A on bar39
    bodies.bar39.points.B.x = 1 m             place of B on bar39
    bodies.bar39.points.B.y = 0 m             place of B on bar39
    bodies.bar39.mass = 1 kg                  mass of bar39
    bodies.bar4.points.A.x = 0 m              place of A on bar4
    bodies.bar4.points.A.y = 0 m              place of A on bar4
    bodies.bar4.points.B.x = 1 m              place of B on bar4
    bodies.bar4.points.B.y = 0 m              place of B on bar4
    bodies.bar4.mass = 1 kg                   mass of bar4
    bodies.bar5.points.A.x = 0 m              place of A on bar5
    bodies.bar5.points.A.y = 0 m              place of A on bar5
    bodies.bar5.points.B.x = 1 m              place of B on bar5
    bodies.bar5.points.B.y = 0 m              place of B on bar5
    bodies.bar5.mass = 1 kg                   mass of bar5
    bodies.bar6.points.A.x = 0 m              place of A on bar6
    bodies.bar6.points.A.y = 0 m              place of A on bar6
    bodies.bar6.points.B.x = 1 m              place of B on bar6
    bodies.bar6.points.B.y = 0 m              place of B on bar6
    bodies.bar6.mass = 1 kg                   mass of bar6
    bodies.bar7.points.A.x = 0 m              place of A on bar7
    bodies.bar7.points.A.y = 0 m              place of A on bar7
    bodies.bar7.points.B.x = 1 m              place of B on bar7
    bodies.bar7.points.B.y = 0 m              place of B on bar7
    bodies.bar7.mass = 1 kg                   mass of bar7
    bodies.bar8.points.A.x = 0 m              place of A on bar8
    bodies.bar8.points.A.y = 0 m              place of A on bar8
    bodies.bar8.points.B.x = 1 m              place of B on bar8
    bodies.bar8.points.B.y = 0 m              place of B on bar8
    bodies.bar8.mass = 1 kg                   mass of bar8
    bodies.bar9.points.A.x = 0 m              place of A on bar9
    bodies.bar9.points.A.y = 0 m              place of A on bar9
    bodies.bar9.points.B.x = 1 m              place of B on bar9
    bodies.bar9.points.B.y = 0 m              place of B on bar9
    bodies.bar9.mass = 1 kg                   mass of bar9
    bodies.rocker0.points.A.x = 0 m           place of A on rocker0
    bodies.rocker0.points.A.y = 0 m           place of A on rocker0
    bodies.rocker0.points.B.x = 1 m           place of B on rocker0
    bodies.rocker0.points.B.y = 0 m           place of B on rocker0
    bodies.rocker0.mass = 1 kg                mass of rocker0
    bodies.rocker1.points.A.x = 0 m           place of A on rocker1
    bodies.rocker1.points.A.y = 0 m           place of A on rocker1
    bodies.rocker1.points.B.x = 1 m           place of B on rocker1
    bodies.rocker1.points.B.y = 0 m           place of B on rocker1
    bodies.rocker1.mass = 1 kg                mass of rocker1
    bodies.rocker10.points.A.x = 0 m          place of A on rocker10
    bodies.rocker10.points.A.y = 0 m          place of A on rocker10
    bodies.rocker10.points.B.x = 1 m          place of B on rocker10
    bodies.rocker10.points.B.y = 0 m          place of B on rocker10
    bodies.rocker10.mass = 1 kg               mass of rocker10
    bodies.rocker11.points.A.x = 0 m          place of A on rocker11
    bodies.rocker11.points.A.y = 0 m          place of A on rocker11
    bodies.rocker11.points.B.x = 1 m          place of B on rocker11
    bodies.rocker11.points.B.y = 0 m          place of B on rocker11
    bodies.rocker11.mass = 1 kg               mass of rocker11
    bodies.rocker12.points.A.x = 0 m          place of A on rocker12
    bodies.rocker12.points.A.y = 0 m          place of A on rocker12
    bodies.rocker12.points.B.x = 1 m          place of B on rocker12
    bodies.rocker12.points.B.y = 0 m          place of B on rocker12
    bodies.rocker12.mass = 1 kg               mass of rocker12
    bodies.rocker13.points.A.x = 0 m          place of A on rocker13
    bodies.rocker13.points.A.y = 0 m          place of A on rocker13
    bodies.rocker13.points.B.x = 1 m          place of B on rocker13
    bodies.rocker13.points.B.y = 0 m          place of B on rocker13
    bodies.rocker13.mass = 1 kg               mass of rocker13
    bodies.rocker14.points.A.x = 0 m          place of A on rocker14
    bodies.rocker14.points.A.y = 0 m          place of A on rocker14
    bodies.rocker14.points.B.x = 1 m          place of B on rocker14
    bodies.rocker14.points.B.y = 0 m          place of B on rocker14
    bodies.rocker14.mass = 1 kg               mass of rocker14
    bodies.rocker15.points.A.x = 0 m          place of A on rocker15
    bodies.rocker15.points.A.y = 0 m          place of A on rocker15
    bodies.rocker15.points.B.x = 1 m          place of B on rocker15
    bodies.rocker15.points.B.y = 0 m          place of B on rocker15
    bodies.rocker15.mass = 1 kg               mass of rocker15
    bodies.rocker16.points.A.x = 0 m          place of A on rocker16
    bodies.rocker16.points.A.y = 0 m          place of A on rocker16
    bodies.rocker16.points.B.x = 1 m          place of B on rocker16
    bodies.rocker16.points.B.y = 0 m          place of B on rocker16
    bodies.rocker16.mass = 1 kg               mass of rocker16
    bodies.rocker17.points.A.x = 0 m          place of A on rocker17
    bodies.rocker17.points.A.y = 0 m          place of A on rocker17
    bodies.rocker17.points.B.x = 1 m          place of B on rocker17
    bodies.rocker17.points.B.y = 0 m          place of B on rocker17
    bodies.rocker17.mass = 1 kg               mass of rocker17
    bodies.rocker18.points.A.x = 0 m          place of A on rocker18
    bodies.rocker18.points.A.y = 0 m          place of A on rocker18
    bodies.rocker18.points.B.x = 1 m          place of B on rocker18
    bodies.rocker18.points.B.y = 0 m          place of B on rocker18
    bodies.rocker18.mass = 1 kg               mass of rocker18
    bodies.rocker19.points.A.x = 0 m          place of A on rocker19
    bodies.rocker19.points.A.y = 0 m          place of A on rocker19
    bodies.rocker19.points.B.x = 1 m          place of B on rocker19
    bodies.rocker19.points.B.y = 0 m          place of B on rocker19
    bodies.rocker19.mass = 1 kg               mass of rocker19
    bodies.rocker2.points.A.x = 0 m           place of A on rocker2
    bodies.rocker2.points.A.y = 0 m           place of A on rocker2
    bodies.rocker2.points.B.x = 1 m           place of B on rocker2
    bodies.rocker2.points.B.y = 0 m           place of B on rocker2
    bodies.rocker2.mass = 1 kg                mass of rocker2
    bodies.rocker20.points.A.x = 0 m          place of A on rocker20
    bodies.rocker20.points.A.y = 0 m          place of A on rocker20
    bodies.rocker20.points.B.x = 1 m          place of B on rocker20
    bodies.rocker20.points.B.y = 0 m          place of B on rocker20
    bodies.rocker20.mass = 1 kg               mass of rocker20
    bodies.rocker21.points.A.x = 0 m          place of A on rocker21
    bodies.rocker21.points.A.y = 0 m          place of A on rocker21
    bodies.rocker21.points.B.x = 1 m          place of B on rocker21
    bodies.rocker21.points.B.y = 0 m          place of B on rocker21
    bodies.rocker21.mass = 1 kg               mass of rocker21
    bodies.rocker22.points.A.x = 0 m          place of A on rocker22
    bodies.rocker22.points.A.y = 0 m          place of A on rocker22
    bodies.rocker22.points.B.x = 1 m          place of B on rocker22
    bodies.rocker22.points.B.y = 0 m          place of B on rocker22
    bodies.rocker22.mass = 1 kg               mass of rocker22
    bodies.rocker23.points.A.x = 0 m          place of A on rocker23
    bodies.rocker23.points.A.y = 0 m          place of A on rocker23
    bodies.rocker23.points.B.x = 1 m          place of B on rocker23
    bodies.rocker23.points.B.y = 0 m          place of B on rocker23
    bodies.rocker23.mass = 1 kg               mass of rocker23
    bodies.rocker24.points.A.x = 0 m          place of A on rocker24
    bodies.rocker24.points.A.y = 0 m          place of A on rocker24
    bodies.rocker24.points.B.x = 1 m          place of B on rocker24
    bodies.rocker24.points.B.y = 0 m          place of B on rocker24
    bodies.rocker24.mass = 1 kg               mass of rocker24
    bodies.rocker25.points.A.x = 0 m          place of A on rocker25
    bodies.rocker25.points.A.y = 0 m          place of A on rocker25
    bodies.rocker25.points.B.x = 1 m          place of B on rocker25
    bodies.rocker25.points.B.y = 0 m          place of B on rocker25
    bodies.rocker25.mass = 1 kg               mass of rocker25
    bodies.rocker26.points.A.x = 0 m          place of A on rocker26
    bodies.rocker26.points.A.y = 0 m          place of A on rocker26
    bodies.rocker26.points.B.x = 1 m          place of B on rocker26
    bodies.rocker26.points.B.y = 0 m          place of B on rocker26
    bodies.rocker26.mass = 1 kg               mass of rocker26
    bodies.rocker27.points.A.x = 0 m          place of A on rocker27
    bodies.rocker27.points.A.y = 0 m          place of A on rocker27
    bodies.rocker27.points.B.x = 1 m          place of B on rocker27
    bodies.rocker27.points.B.y = 0 m          place of B on rocker27
    bodies.rocker27.mass = 1 kg               mass of rocker27
    bodies.rocker28.points.A.x = 0 m          place of A on rocker28
    bodies.rocker28.points.A.y = 0 m          place of A on rocker28
    bodies.rocker28.points.B.x = 1 m          place of B on rocker28
    bodies.rocker28.points.B.y = 0 m          place of B on rocker28
    bodies.rocker28.mass = 1 kg               mass of rocker28
    bodies.rocker29.points.A.x = 0 m          place of A on rocker29
    bodies.rocker29.points.A.y = 0 m          place of A on rocker29
    bodies.rocker29.points.B.x = 1 m          place of B on rocker29
    bodies.rocker29.points.B.y = 0 m          place of B on rocker29
    bodies.rocker29.mass = 1 kg               mass of rocker29
    bodies.rocker3.points.A.x = 0 m           place of A on rocker3
    bodies.rocker3.points.A.y = 0 m           place of A on rocker3
    bodies.rocker3.points.B.x = 1 m           place of B on rocker3
    bodies.rocker3.points.B.y = 0 m           place of B on rocker3
    bodies.rocker3.mass = 1 kg                mass of rocker3
    bodies.rocker30.points.A.x = 0 m          place of A on rocker30
    bodies.rocker30.points.A.y = 0 m          place of A on rocker30
    bodies.rocker30.points.B.x = 1 m          place of B on rocker30
    bodies.rocker30.points.B.y = 0 m          place of B on rocker30
    bodies.rocker30.mass = 1 kg               mass of rocker30
    bodies.rocker31.points.A.x = 0 m          place of A on rocker31
    bodies.rocker31.points.A.y = 0 m          place of A on rocker31
    bodies.rocker31.points.B.x = 1 m          place of B on rocker31
    bodies.rocker31.points.B.y = 0 m          place of B on rocker31
    bodies.rocker31.mass = 1 kg               mass of rocker31
    bodies.rocker32.points.A.x = 0 m          place of A on rocker32
    bodies.rocker32.points.A.y = 0 m          place of A on rocker32
    bodies.rocker32.points.B.x = 1 m          place of B on rocker32
    bodies.rocker32.points.B.y = 0 m          place of B on rocker32
    bodies.rocker32.mass = 1 kg               mass of rocker32
    bodies.rocker33.points.A.x = 0 m          place of A on rocker33
    bodies.rocker33.points.A.y = 0 m          place of A on rocker33
    bodies.rocker33.points.B.x = 1 m          place of B on rocker33
    bodies.rocker33.points.B.y = 0 m          place of B on rocker33
    bodies.rocker33.mass = 1 kg               mass of rocker33
    bodies.rocker34.points.A.x = 0 m          place of A on rocker34
    bodies.rocker34.points.A.y = 0 m          place of A on rocker34
    bodies.rocker34.points.B.x = 1 m          place of B on rocker34
    bodies.rocker34.points.B.y = 0 m          place of B on rocker34
    bodies.rocker34.mass = 1 kg               mass of rocker34
    bodies.rocker35.points.A.x = 0 m          place of A on rocker35
    bodies.rocker35.points.A.y = 0 m          place of A on rocker35
    bodies.rocker35.points.B.x = 1 m          place of B on rocker35
    bodies.rocker35.points.B.y = 0 m          place of B on rocker35
    bodies.rocker35.mass = 1 kg               mass of rocker35
    bodies.rocker36.points.A.x = 0 m          place of A on rocker36
    bodies.rocker36.points.A.y = 0 m          place of A on rocker36
    bodies.rocker36.points.B.x = 1 m          place of B on rocker36
    bodies.rocker36.points.B.y = 0 m          place of B on rocker36
    bodies.rocker36.mass = 1 kg               mass of rocker36
    bodies.rocker37.points.A.x = 0 m          place of A on rocker37
    bodies.rocker37.points.A.y = 0 m          place of A on rocker37
    bodies.rocker37.points.B.x = 1 m          place of B on rocker37
    bodies.rocker37.points.B.y = 0 m          place of B on rocker37
    bodies.rocker37.mass = 1 kg               mass of rocker37
    bodies.rocker38.points.A.x = 0 m          place of A on rocker38
    bodies.rocker38.points.A.y = 0 m          place of A on rocker38
    bodies.rocker38.points.B.x = 1 m          place of B on rocker38
    bodies.rocker38.points.B.y = 0 m          place of B on rocker38
    bodies.rocker38.mass = 1 kg               mass of rocker38
    bodies.rocker39.points.A.x = 0 m          place of A on rocker39
    bodies.rocker39.points.A.y = 0 m          place of A on rocker39
    bodies.rocker39.points.B.x = 1 m          place of B on rocker39
    bodies.rocker39.points.B.y = 0 m          place of B on rocker39
    bodies.rocker39.mass = 1 kg               mass of rocker39
    bodies.rocker4.points.A.x = 0 m           place of A on rocker4
    bodies.rocker4.points.A.y = 0 m           place of A on rocker4
    bodies.rocker4.points.B.x = 1 m           place of B on rocker4
    bodies.rocker4.points.B.y = 0 m           place of B on rocker4
    bodies.rocker4.mass = 1 kg                mass of rocker4
    bodies.rocker40.points.A.x = 0 m          place of A on rocker40
    bodies.rocker40.points.A.y = 0 m          place of A on rocker40
    bodies.rocker40.points.B.x = 1 m          place of B on rocker40
    bodies.rocker40.points.B.y = 0 m          place of B on rocker40
    bodies.rocker40.mass = 1 kg               mass of rocker40
    bodies.rocker5.points.A.x = 0 m           place of A on rocker5
    bodies.rocker5.points.A.y = 0 m           place of A on rocker5
    bodies.rocker5.points.B.x = 1 m           place of B on rocker5
    bodies.rocker5.points.B.y = 0 m           place of B on rocker5
    bodies.rocker5.mass = 1 kg                mass of rocker5
    bodies.rocker6.points.A.x = 0 m           place of A on rocker6
    bodies.rocker6.points.A.y = 0 m           place of A on rocker6
    bodies.rocker6.points.B.x = 1 m           place of B on rocker6
    bodies.rocker6.points.B.y = 0 m           place of B on rocker6
    bodies.rocker6.mass = 1 kg                mass of rocker6
    bodies.rocker7.points.A.x = 0 m           place of A on rocker7
    bodies.rocker7.points.A.y = 0 m           place of A on rocker7
    bodies.rocker7.points.B.x = 1 m           place of B on rocker7
    bodies.rocker7.points.B.y = 0 m           place of B on rocker7
    bodies.rocker7.mass = 1 kg                mass of rocker7
    bodies.rocker8.points.A.x = 0 m           place of A on rocker8
    bodies.rocker8.points.A.y = 0 m           place of A on rocker8
    bodies.rocker8.points.B.x = 1 m           place of B on rocker8
    bodies.rocker8.points.B.y = 0 m           place of B on rocker8
    bodies.rocker8.mass = 1 kg                mass of rocker8
    bodies.rocker9.points.A.x = 0 m           place of A on rocker9
    bodies.rocker9.points.A.y = 0 m           place of A on rocker9
    bodies.rocker9.points.B.x = 1 m           place of B on rocker9
    bodies.rocker9.points.B.y = 0 m           place of B on rocker9
    bodies.rocker9.mass = 1 kg                mass of rocker9
    ground.points.O0.x = 0 m                  place of O0 on the ground
    ground.points.O0.y = 0 m                  place of O0 on the ground
    ground.points.O1.x = 1 m                  place of O1 on the ground
    ground.points.O1.y = 0 m                  place of O1 on the ground
    ground.points.O10.x = 10 m                place of O10 on the ground
    ground.points.O10.y = 0 m                 place of O10 on the ground
    ground.points.O11.x = 11 m                place of O11 on the ground
    ground.points.O11.y = 0 m                 place of O11 on the ground
    ground.points.O12.x = 12 m                place of O12 on the ground
    ground.points.O12.y = 0 m                 place of O12 on the ground
    ground.points.O13.x = 13 m                place of O13 on the ground
    ground.points.O13.y = 0 m                 place of O13 on the ground
    ground.points.O14.x = 14 m                place of O14 on the ground
    ground.points.O14.y = 0 m                 place of O14 on the ground
    ground.points.O15.x = 15 m                place of O15 on the ground
    ground.points.O15.y = 0 m                 place of O15 on the ground
    ground.points.O16.x = 16 m                place of O16 on the ground
    ground.points.O16.y = 0 m                 place of O16 on the ground
    ground.points.O17.x = 17 m                place of O17 on the ground
    ground.points.O17.y = 0 m                 place of O17 on the ground
    ground.points.O18.x = 18 m                place of O18 on the ground
    ground.points.O18.y = 0 m                 place of O18 on the ground
    ground.points.O19.x = 19 m                place of O19 on the ground
    ground.points.O19.y = 0 m                 place of O19 on the ground
    ground.points.O2.x = 2 m                  place of O2 on the ground
    ground.points.O2.y = 0 m                  place of O2 on the ground
    ground.points.O20.x = 20 m                place of O20 on the ground
    ground.points.O20.y = 0 m                 place of O20 on the ground
    ground.points.O21.x = 21 m                place of O21 on the ground
    ground.points.O21.y = 0 m                 place of O21 on the ground
    ground.points.O22.x = 22 m                place of O22 on the ground
    ground.points.O22.y = 0 m                 place of O22 on the ground
    ground.points.O23.x = 23 m                place of O23 on the ground
    ground.points.O23.y = 0 m                 place of O23 on the ground
    ground.points.O24.x = 24 m                place of O24 on the ground
    ground.points.O24.y = 0 m                 place of O24 on the ground
    ground.points.O25.x = 25 m                place of O25 on the ground
    ground.points.O25.y = 0 m                 place of O25 on the ground
    ground.points.O26.x = 26 m                place of O26 on the ground
    ground.points.O26.y = 0 m                 place of O26 on the ground
    ground.points.O27.x = 27 m                place of O27 on the ground
    ground.points.O27.y = 0 m                 place of O27 on the ground
    ground.points.O28.x = 28 m                place of O28 on the ground
    ground.points.O28.y = 0 m                 place of O28 on the ground
    ground.points.O29.x = 29 m                place of O29 on the ground
    ground.points.O29.y = 0 m                 place of O29 on the ground
    ground.points.O3.x = 3 m                  place of O3 on the ground
    ground.points.O3.y = 0 m                  place of O3 on the ground
    ground.points.O30.x = 30 m                place of O30 on the ground
    ground.points.O30.y = 0 m                 place of O30 on the ground
    ground.points.O31.x = 31 m                place of O31 on the ground
    ground.points.O31.y = 0 m                 place of O31 on the ground
    ground.points.O32.x = 32 m                place of O32 on the ground
    ground.points.O32.y = 0 m                 place of O32 on the ground
    ground.points.O33.x = 33 m                place of O33 on the ground
    ground.points.O33.y = 0 m                 place of O33 on the ground
    ground.points.O34.x = 34 m                place of O34 on the ground
    ground.points.O34.y = 0 m                 place of O34 on the ground
    ground.points.O35.x = 35 m                place of O35 on the ground
    ground.points.O35.y = 0 m                 place of O35 on the ground
    ground.points.O36.x = 36 m                place of O36 on the ground
    ground.points.O36.y = 0 m                 place of O36 on the ground
    ground.points.O37.x = 37 m                place of O37 on the ground
    ground.points.O37.y = 0 m                 place of O37 on the ground
    ground.points.O38.x = 38 m                place of O38 on the ground
    ground.points.O38.y = 0 m                 place of O38 on the ground
    ground.points.O39.x = 39 m                place of O39 on the ground
    ground.points.O39.y = 0 m                 place of O39 on the ground
    ground.points.O4.x = 4 m                  place of O4 on the ground
    ground.points.O4.y = 0 m                  place of O4 on the ground
    ground.points.O40.x = 40 m                place of O40 on the ground
    ground.points.O40.y = 0 m                 place of O40 on the ground
    ground.points.O5.x = 5 m                  place of O5 on the ground
    ground.points.O5.y = 0 m                  place of O5 on the ground
    ground.points.O6.x = 6 m                  place of O6 on the ground
    ground.points.O6.y = 0 m                  place of O6 on the ground
    ground.points.O7.x = 7 m                  place of O7 on the ground
    ground.points.O7.y = 0 m                  place of O7 on the ground
    ground.points.O8.x = 8 m                  place of O8 on the ground
    ground.points.O8.y = 0 m                  place of O8 on the ground
    ground.points.O9.x = 9 m                  place of O9 on the ground
    ground.points.O9.y = 0 m                  place of O9 on the ground
    speed = 1 rad/s                           crank speed; negative is the other sense of rotation
    driver.start = 1.57079633 rad             turn of the crank at crank angle 0
    driver.from = -1.3962634 rad              crank angle at which the pass begins
    driver.to = 1.3962634 rad                 crank angle at which the pass ends
    start.bar0.turn = 0 rad                   about the turn of bar0 at the start
    start.bar1.turn = 0 rad                   about the turn of bar1 at the start
    start.bar10.turn = 0 rad                  about the turn of bar10 at the start
    start.bar11.turn = 0 rad                  about the turn of bar11 at the start
    start.bar12.turn = 0 rad                  about the turn of bar12 at the start
    start.bar13.turn = 0 rad                  about the turn of bar13 at the start
    start.bar14.turn = 0 rad                  about the turn of bar14 at the start
    start.bar15.turn = 0 rad                  about the turn of bar15 at the start
    start.bar16.turn = 0 rad                  about the turn of bar16 at the start
    start.bar17.turn = 0 rad                  about the turn of bar17 at the start
    start.bar18.turn = 0 rad                  about the turn of bar18 at the start
    start.bar19.turn = 0 rad                  about the turn of bar19 at the start
    start.bar2.turn = 0 rad                   about the turn of bar2 at the start
    start.bar20.turn = 0 rad                  about the turn of bar20 at the start
    start.bar21.turn = 0 rad                  about the turn of bar21 at the start
    start.bar22.turn = 0 rad                  about the turn of bar22 at the start
    start.bar23.turn = 0 rad                  about the turn of bar23 at the start
    start.bar24.turn = 0 rad                  about the turn of bar24 at the start
    start.bar25.turn = 0 rad                  about the turn of bar25 at the start
    start.bar26.turn = 0 rad                  about the turn of bar26 at the start
    start.bar27.turn = 0 rad                  about the turn of bar27 at the start
    start.bar28.turn = 0 rad                  about the turn of bar28 at the start
    start.bar29.turn = 0 rad                  about the turn of bar29 at the start
    start.bar3.turn = 0 rad                   about the turn of bar3 at the start
    start.bar30.turn = 0 rad                  about the turn of bar30 at the start
    start.bar31.turn = 0 rad                  about the turn of bar31 at the start
    start.bar32.turn = 0 rad                  about the turn of bar32 at the start
    start.bar33.turn = 0 rad                  about the turn of bar33 at the start
    start.bar34.turn = 0 rad                  about the turn of bar34 at the start
    start.bar35.turn = 0 rad                  about the turn of bar35 at the start
    start.bar36.turn = 0 rad                  about the turn of bar36 at the start
    start.bar37.turn = 0 rad                  about the turn of bar37 at the start
    start.bar38.turn = 0 rad                  about the turn of bar38 at the start
    start.bar39.turn = 0 rad                  about the turn of bar39 at the start
    start.bar4.turn = 0 rad                   about the turn of bar4 at the start
    start.bar5.turn = 0 rad                   about the turn of bar5 at the start
    start.bar6.turn = 0 rad                   about the turn of bar6 at the start
    start.bar7.turn = 0 rad                   about the turn of bar7 at the start
    start.bar8.turn = 0 rad                   about the turn of bar8 at the start
    start.bar9.turn = 0 rad                   about the turn of bar9 at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the first rocker's pivot is at (0, 0), the
others on +x; y is up; crank angles count clockwise from upright

Nothing holds the speed of body 'rocker0', the crank: it has its own mass, and moves as weight and loads
demand. Its start, counter-clockwise: rocker0 -1 rad/s.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 0.00628319 s a step. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

CRANK = "rocker0"
TIMESTEP = 0.006283185307179587  # s
RUN_STEPS = 2000
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 3200  # of the solver, in a step
ERROR_BIAS = 0.0  # share of a joint's error that is left after a second


class Model:
    """The machine in its space.

    Attributes:
        space: the `pymunk.Space`.
        bodies, constraints: those of the machine, by name.
        points: observed points: body, and place in the body's frame, whose origin is its centre of gravity [m].
        timestep: [s].
        steps: number of steps taken.
    """

    def __init__(self, space, bodies, constraints, points):
        self.space, self.bodies, self.constraints, self.points = space, bodies, constraints, points
        self.timestep, self.steps = TIMESTEP, 0

    @property
    def time(self):
        """Time [s] of the positions, from the number of steps: a sum of steps would drift."""
        return self.timestep * self.steps

    def position(self, point):
        """Position (x, y) [m] of an observed point."""
        body, place = self.points[point]
        return tuple(self.bodies[body].local_to_world(place))


def configure(space):
    """Give a space the gravity and the solver settings that conrod judges this machine with."""
    space.gravity, space.iterations = GRAVITY, ITERATIONS


def build(space=None):
    """Build the machine, in motion, and return its `Model`.

    Args:
        space: space to add the machine to, which keeps its own settings; None for a new one with those of `configure`.
    """
    if space is None:
        space = pymunk.Space()
        configure(space)
    # Mass [kg], moment of inertia [kg m²] about the centre of gravity: infinite on a slide of the ground.
    bodies = {
        "rocker0": pymunk.Body(1.0, 0.08333333333333333),
        "bar0": pymunk.Body(1.0, 0.08333333333333333),
        "rocker1": pymunk.Body(1.0, 0.08333333333333333),
        "bar1": pymunk.Body(1.0, 0.08333333333333333),
        "rocker2": pymunk.Body(1.0, 0.08333333333333333),
        "bar2": pymunk.Body(1.0, 0.08333333333333333),
        "rocker3": pymunk.Body(1.0, 0.08333333333333333),
        "bar3": pymunk.Body(1.0, 0.08333333333333333),
        "rocker4": pymunk.Body(1.0, 0.08333333333333333),
        "bar4": pymunk.Body(1.0, 0.08333333333333333),
        "rocker5": pymunk.Body(1.0, 0.08333333333333333),
        "bar5": pymunk.Body(1.0, 0.08333333333333333),
        "rocker6": pymunk.Body(1.0, 0.08333333333333333),
        "bar6": pymunk.Body(1.0, 0.08333333333333333),
        "rocker7": pymunk.Body(1.0, 0.08333333333333333),
        "bar7": pymunk.Body(1.0, 0.08333333333333333),
        "rocker8": pymunk.Body(1.0, 0.08333333333333333),
        "bar8": pymunk.Body(1.0, 0.08333333333333333),
        "rocker9": pymunk.Body(1.0, 0.08333333333333333),
        "bar9": pymunk.Body(1.0, 0.08333333333333333),
        "rocker10": pymunk.Body(1.0, 0.08333333333333333),
        "bar10": pymunk.Body(1.0, 0.08333333333333333),
        "rocker11": pymunk.Body(1.0, 0.08333333333333333),
        "bar11": pymunk.Body(1.0, 0.08333333333333333),
        "rocker12": pymunk.Body(1.0, 0.08333333333333333),
        "bar12": pymunk.Body(1.0, 0.08333333333333333),
        "rocker13": pymunk.Body(1.0, 0.08333333333333333),
        "bar13": pymunk.Body(1.0, 0.08333333333333333),
        "rocker14": pymunk.Body(1.0, 0.08333333333333333),
        "bar14": pymunk.Body(1.0, 0.08333333333333333),
        "rocker15": pymunk.Body(1.0, 0.08333333333333333),
        "bar15": pymunk.Body(1.0, 0.08333333333333333),
        "rocker16": pymunk.Body(1.0, 0.08333333333333333),
        "bar16": pymunk.Body(1.0, 0.08333333333333333),
        "rocker17": pymunk.Body(1.0, 0.08333333333333333),
        "bar17": pymunk.Body(1.0, 0.08333333333333333),
        "rocker18": pymunk.Body(1.0, 0.08333333333333333),
        "bar18": pymunk.Body(1.0, 0.08333333333333333),
        "rocker19": pymunk.Body(1.0, 0.08333333333333333),
        "bar19": pymunk.Body(1.0, 0.08333333333333333),
        "rocker20": pymunk.Body(1.0, 0.08333333333333333),
        "bar20": pymunk.Body(1.0, 0.08333333333333333),
        "rocker21": pymunk.Body(1.0, 0.08333333333333333),
        "bar21": pymunk.Body(1.0, 0.08333333333333333),
        "rocker22": pymunk.Body(1.0, 0.08333333333333333),
        "bar22": pymunk.Body(1.0, 0.08333333333333333),
        "rocker23": pymunk.Body(1.0, 0.08333333333333333),
        "bar23": pymunk.Body(1.0, 0.08333333333333333),
        "rocker24": pymunk.Body(1.0, 0.08333333333333333),
        "bar24": pymunk.Body(1.0, 0.08333333333333333),
        "rocker25": pymunk.Body(1.0, 0.08333333333333333),
        "bar25": pymunk.Body(1.0, 0.08333333333333333),
        "rocker26": pymunk.Body(1.0, 0.08333333333333333),
        "bar26": pymunk.Body(1.0, 0.08333333333333333),
        "rocker27": pymunk.Body(1.0, 0.08333333333333333),
        "bar27": pymunk.Body(1.0, 0.08333333333333333),
        "rocker28": pymunk.Body(1.0, 0.08333333333333333),
        "bar28": pymunk.Body(1.0, 0.08333333333333333),
        "rocker29": pymunk.Body(1.0, 0.08333333333333333),
        "bar29": pymunk.Body(1.0, 0.08333333333333333),
        "rocker30": pymunk.Body(1.0, 0.08333333333333333),
        "bar30": pymunk.Body(1.0, 0.08333333333333333),
        "rocker31": pymunk.Body(1.0, 0.08333333333333333),
        "bar31": pymunk.Body(1.0, 0.08333333333333333),
        "rocker32": pymunk.Body(1.0, 0.08333333333333333),
        "bar32": pymunk.Body(1.0, 0.08333333333333333),
        "rocker33": pymunk.Body(1.0, 0.08333333333333333),
        "bar33": pymunk.Body(1.0, 0.08333333333333333),
        "rocker34": pymunk.Body(1.0, 0.08333333333333333),
        "bar34": pymunk.Body(1.0, 0.08333333333333333),
        "rocker35": pymunk.Body(1.0, 0.08333333333333333),
        "bar35": pymunk.Body(1.0, 0.08333333333333333),
        "rocker36": pymunk.Body(1.0, 0.08333333333333333),
        "bar36": pymunk.Body(1.0, 0.08333333333333333),
        "rocker37": pymunk.Body(1.0, 0.08333333333333333),
        "bar37": pymunk.Body(1.0, 0.08333333333333333),
        "rocker38": pymunk.Body(1.0, 0.08333333333333333),
        "bar38": pymunk.Body(1.0, 0.08333333333333333),
        "rocker39": pymunk.Body(1.0, 0.08333333333333333),
        "bar39": pymunk.Body(1.0, 0.08333333333333333),
        "rocker40": pymunk.Body(1.0, 0.08333333333333333),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "rocker0": (
            (-3.0245073740886313e-16, 0.5),
            1.5707963267948972,
            (0.4999999999999971, 3.024507374088614e-16),
            -0.9999999999999942,
        ),
        "bar0": (
            (0.5000000000000001, 0.9999999999999997),
            9.244463733058732e-33,
            (0.9999999999999943, -3.8021045369256036e-17),
            3.120006509907322e-32,
        ),
        "rocker1": (
            (0.9999999999999996, 0.5),
            1.5707963267948968,
            (0.49999999999999717, 1.1102230246251503e-16),
            -0.9999999999999943,
        ),
        "bar1": (
            (1.5000000000000002, 0.9999999999999999),
            -1.5407439555097887e-33,
            (0.9999999999999943, -7.21734138025494e-17),
            1.1093356479670479e-31,
        ),
        "rocker2": (
            (1.9999999999999991, 0.5),
            1.5707963267948972,
            (0.49999999999999717, 2.2204460492503005e-16),
            -0.9999999999999943,
        ),
        "bar2": (
            (2.5, 0.9999999999999998),
            7.974553675978398e-35,
            (0.9999999999999943, -6.743680556147462e-17),
            -5.200010849845537e-33,
        ),
        "rocker3": ((3.0, 0.5), 1.5707963267948972, (0.49999999999999717, 4.440892098500601e-16), -0.9999999999999943),
        "bar3": (
            (3.4999999999999996, 0.9999999999999998),
            6.162975822039155e-33,
            (0.9999999999999943, -6.318832652609196e-17),
            4.1600086798764294e-31,
        ),
        "rocker4": (
            (3.9999999999999982, 0.5),
            1.5707963267948974,
            (0.49999999999999706, 4.4408920985005986e-16),
            -0.9999999999999941,
        ),
        "bar4": (
            (4.500000000000001, 0.9999999999999997),
            -1.5407439555097887e-32,
            (0.9999999999999943, -6.74368055614749e-17),
            -8.320017359752859e-32,
        ),
        "rocker5": ((5.0, 0.5), 1.5707963267948972, (0.500000000000001, 4.992010415851715e-31), -1.000000000000002),
        "bar5": (
            (5.500000000000002, 0.9999999999999998),
            2.7637094701956834e-32,
            (1.0000000000000022, -7.197036412322451e-17),
            1.9413373839423337e-31,
        ),
        "rocker6": (
            (6.000000000000001, 0.5),
            1.570796326794897,
            (0.4999999999999996, -5.546678239835239e-32),
            -0.9999999999999992,
        ),
        "bar6": (
            (6.500000000000001, 0.9999999999999996),
            -1.232595164407831e-32,
            (0.9999999999999991, -8.855865736225282e-17),
            2.7733391199176196e-32,
        ),
        "rocker7": (
            (6.999999999999999, 0.5),
            1.570796326794897,
            (0.5000000000000001, 1.2480026039629288e-31),
            -1.0000000000000002,
        ),
        "bar7": ((7.5, 0.9999999999999998), 0.0, (1.0, -2.3384316040701532e-17), 1.1093356479670479e-31),
        "rocker8": (
            (7.999999999999997, 0.5),
            1.5707963267948966,
            (0.5000000000000008, 2.3573382519299767e-31),
            -1.0000000000000016,
        ),
        "bar8": (
            (8.5, 0.9999999999999997),
            -4.622231866529366e-32,
            (1.000000000000001, -2.318126636137704e-17),
            -2.288004773932036e-31,
        ),
        "rocker9": ((9.0, 0.5), 1.5707963267948968, (0.5000000000000006, 2.704005641919679e-31), -1.000000000000001),
        "bar9": (
            (9.500000000000002, 0.9999999999999996),
            -3.0814879110195774e-33,
            (1.0000000000000009, -6.450945969576419e-17),
            -3.3280069439011436e-31,
        ),
        "rocker10": ((10.0, 0.5), 1.5707963267948968, (0.5000000000000011, 6.933347799794049e-32), -1.0000000000000022),
        "bar10": (
            (10.5, 0.9999999999999998),
            4.5451946687538766e-32,
            (1.0000000000000022, -7.329149729289654e-17),
            1.698670210949542e-31,
        ),
        "rocker11": (
            (10.999999999999996, 0.5),
            1.5707963267948966,
            (0.5000000000000004, 1.1786691259649883e-31),
            -1.0000000000000009,
        ),
        "bar11": (
            (11.499999999999996, 0.9999999999999998),
            -1.232595164407831e-32,
            (1.0000000000000007, 1.0625750857481659e-17),
            1.3866695599588098e-31,
        ),
        "rocker12": (
            (12.000000000000002, 0.5),
            1.5707963267948974,
            (0.5000000000000001, 5.546678239835239e-32),
            -1.0000000000000002,
        ),
        "bar12": ((12.500000000000002, 1.0), 0.0, (1.0000000000000004, 5.889142616406953e-18), 1.0053354309701371e-31),
        "rocker13": ((13.000000000000005, 0.5), 1.5707963267948968, (0.5, 1.42133629895778e-31), -1.0),
        "bar13": (
            (13.500000000000004, 0.9999999999999998),
            -3.697785493223493e-32,
            (0.9999999999999996, -6.841258751671185e-17),
            8.320017359752859e-32,
        ),
        "rocker14": (
            (13.999999999999998, 0.5),
            1.5707963267948966,
            (0.5000000000000004, 1.8026704279464528e-31),
            -1.0000000000000009,
        ),
        "bar14": (
            (14.499999999999996, 0.9999999999999993),
            -1.5407439555097887e-33,
            (1.0000000000000004, -5.928519870514435e-17),
            2.0800043399382147e-32,
        ),
        "rocker15": ((15.0, 0.5), 1.5707963267948966, (0.5, -6.933347799794049e-32), -1.0),
        "bar15": (
            (15.499999999999998, 0.9999999999999993),
            -5.546678239835239e-32,
            (0.9999999999999998, -3.314213559307109e-17),
            -1.3866695599588098e-31,
        ),
        "rocker16": (
            (15.999999999999995, 0.5),
            1.5707963267948968,
            (0.5000000000000001, 1.1786691259649883e-31),
            -1.0000000000000002,
        ),
        "bar16": ((16.5, 1.0), 3.550933334963966e-34, (1.0, -7.997966944444481e-17), 4.1600086798764294e-32),
        "rocker17": ((17.0, 0.5), 1.5707963267948968, (0.5000000000000006, 2.149337817936155e-31), -1.000000000000001),
        "bar17": (
            (17.500000000000004, 1.0),
            -6.2592723192585165e-34,
            (1.0000000000000009, -3.3284437128181547e-17),
            -1.3866695599588098e-31,
        ),
        "rocker18": (
            (18.0, 0.5),
            1.5707963267948968,
            (0.5000000000000008, 4.1600086798764294e-32),
            -1.0000000000000016,
        ),
        "bar18": (
            (18.500000000000004, 1.0),
            7.395570986446986e-32,
            (1.0000000000000013, -4.8754646876862327e-17),
            1.1093356479670479e-31,
        ),
        "rocker19": (
            (18.999999999999993, 0.5),
            1.5707963267948966,
            (0.5000000000000001, -1.9196706720679773e-31),
            -1.0000000000000002,
        ),
        "bar19": (
            (19.5, 0.9999999999999999),
            3.697785493223493e-32,
            (1.0, -7.119763184731202e-17),
            4.0213417238805485e-31,
        ),
        "rocker20": (
            (20.0, 0.5),
            1.5707963267948968,
            (0.5000000000000008, 1.1093356479670479e-31),
            -1.0000000000000016,
        ),
        "bar20": (
            (20.500000000000007, 1.0),
            2.8888949165808538e-33,
            (1.0000000000000016, -9.636491300414876e-17),
            -9.013352139732264e-32,
        ),
        "rocker21": (
            (21.000000000000007, 0.5),
            1.5707963267948968,
            (0.5000000000000008, -3.120006509907322e-32),
            -1.0000000000000016,
        ),
        "bar21": (
            (21.49999999999999, 1.0),
            -3.0814879110195774e-32,
            (1.000000000000001, 6.864924571643884e-18),
            -5.546678239835239e-32,
        ),
        "rocker22": (
            (21.999999999999993, 0.5),
            1.5707963267948966,
            (0.5000000000000007, 4.8533434598558343e-32),
            -1.0000000000000013,
        ),
        "bar22": (
            (22.500000000000004, 0.9999999999999999),
            -1.232595164407831e-32,
            (1.000000000000001, 9.792270437354808e-18),
            1.8026704279464528e-31,
        ),
        "rocker23": ((23.0, 0.5), 1.5707963267948968, (0.5000000000000007, 5.546678239835239e-32), -1.0000000000000013),
        "bar23": (
            (23.500000000000007, 1.0),
            1.7513925431771426e-33,
            (1.0000000000000009, -1.2650714533095212e-17),
            -2.7733391199176196e-32,
        ),
        "rocker24": (
            (24.000000000000004, 0.5),
            1.5707963267948968,
            (0.5000000000000001, 6.240013019814644e-32),
            -1.0000000000000002,
        ),
        "bar24": (
            (24.499999999999993, 1.0),
            -1.829633447167874e-33,
            (1.0000000000000009, -3.391486786898357e-17),
            2.0800043399382147e-32,
        ),
        "rocker25": (
            (24.99999999999999, 0.5),
            1.5707963267948968,
            (0.5000000000000003, 5.546678239835239e-32),
            -1.0000000000000007,
        ),
        "bar25": (
            (25.5, 1.0),
            3.3703774026776627e-34,
            (1.0000000000000007, -4.889694841197266e-17),
            7.626682579773454e-32,
        ),
        "rocker26": (
            (26.00000000000001, 0.5),
            1.5707963267948968,
            (0.4999999999999998, -5.200010849845537e-32),
            -0.9999999999999996,
        ),
        "bar26": (
            (26.500000000000004, 1.0),
            -2.2268564981977415e-34,
            (0.9999999999999993, 4.9133606611700126e-18),
            3.4666738998970245e-33,
        ),
        "rocker27": (
            (27.00000000000001, 0.5),
            1.5707963267948968,
            (0.4999999999999999, 1.3866695599588098e-32),
            -0.9999999999999998,
        ),
        "bar27": (
            (27.500000000000007, 1.0),
            9.268537857363573e-34,
            (0.9999999999999998, 4.140628385257624e-18),
            -7.626682579773454e-32,
        ),
        "rocker28": (
            (27.999999999999996, 0.5),
            1.5707963267948968,
            (0.5000000000000004, 2.0800043399382147e-32),
            -1.0000000000000009,
        ),
        "bar28": (
            (28.499999999999993, 1.0),
            1.233798870623073e-33,
            (1.0000000000000009, -2.2205484406140245e-17),
            6.153346172317219e-32,
        ),
        "rocker29": ((29.0, 0.5), 1.5707963267948968, (0.5000000000000001, 6.066679324819793e-32), -1.0000000000000002),
        "bar29": (
            (29.49999999999999, 1.0),
            -8.614022602825723e-34,
            (1.0000000000000002, -3.391486786898362e-17),
            -1.560003254953661e-31,
        ),
        "rocker30": (
            (30.0, 0.5),
            1.5707963267948968,
            (0.5000000000000004, -3.120006509907322e-32),
            -1.0000000000000009,
        ),
        "bar30": (
            (30.50000000000001, 1.0),
            1.1350949609732271e-32,
            (1.0000000000000007, -1.43992287642444e-17),
            1.2133358649639586e-31,
        ),
        "rocker31": (
            (31.000000000000007, 0.5),
            1.5707963267948968,
            (0.5000000000000001, -1.0400021699691074e-32),
            -1.0000000000000002,
        ),
        "bar31": ((31.5, 1.0), 9.860761315262648e-32, (1.0, 2.1359352365088598e-17), 1.2202692127637526e-30),
        "rocker32": (
            (31.99999999999999, 0.5),
            1.5707963267948968,
            (0.5000000000000008, 1.3606695057095821e-31),
            -1.0000000000000016,
        ),
        "bar32": (
            (32.5, 0.9999999999999997),
            -3.851859888774472e-33,
            (1.0000000000000007, -7.412497771302338e-17),
            -5.373344544840388e-32,
        ),
        "rocker33": (
            (32.99999999999999, 0.5),
            1.5707963267948968,
            (0.5000000000000006, 2.253338034933066e-32),
            -1.000000000000001,
        ),
        "bar33": (
            (33.49999999999999, 0.9999999999999997),
            -9.244463733058732e-33,
            (1.0000000000000013, -8.07524017203573e-17),
            3.813341289886727e-32,
        ),
        "rocker34": ((34.0, 0.5), 1.570796326794897, (0.5000000000000004, -3.640007594891876e-32), -1.0000000000000009),
        "bar34": (
            (34.49999999999999, 0.9999999999999997),
            -9.860761315262648e-32,
            (1.0000000000000007, -4.094839123496717e-17),
            -5.546678239835239e-32,
        ),
        "rocker35": ((35.0, 0.5), 1.570796326794897, (0.5000000000000004, 6.066679324819793e-32), -1.0000000000000009),
        "bar35": (
            (35.49999999999999, 0.9999999999999994),
            -4.930380657631324e-32,
            (1.000000000000001, -4.855159719753817e-17),
            -2.2186712959340957e-31,
        ),
        "rocker36": ((36.0, 0.5), 1.5707963267948968, (0.5000000000000007, 8.666684749742561e-33), -1.0000000000000013),
        "bar36": (
            (36.50000000000001, 0.9999999999999997),
            4.237045877651919e-33,
            (1.000000000000001, -6.436715816065389e-17),
            5.546678239835239e-32,
        ),
        "rocker37": (
            (36.99999999999999, 0.5),
            1.5707963267948968,
            (0.5000000000000006, 1.6466701024510867e-32),
            -1.000000000000001,
        ),
        "bar37": (
            (37.50000000000001, 0.9999999999999997),
            -7.395570986446986e-32,
            (1.0000000000000007, -2.4502399531049004e-17),
            2.2186712959340957e-31,
        ),
        "rocker38": (
            (37.999999999999986, 0.5),
            1.570796326794897,
            (0.5000000000000004, 6.933347799794049e-33),
            -1.0000000000000009,
        ),
        "bar38": (
            (38.49999999999999, 0.9999999999999994),
            1.233798870623073e-34,
            (1.0000000000000007, -4.2696905466115776e-17),
            1.3866695599588098e-32,
        ),
        "rocker39": (
            (39.00000000000002, 0.5),
            1.570796326794897,
            (0.5000000000000006, -3.4666738998970245e-33),
            -1.000000000000001,
        ),
        "bar39": (
            (39.50000000000001, 0.9999999999999994),
            -1.6475728821125182e-34,
            (1.0000000000000004, -5.363355665304736e-17),
            2.253338034933066e-32,
        ),
        "rocker40": ((39.999999999999986, 0.5), 1.5707963267948968, (0.5000000000000004, 0.0), -1.0000000000000009),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "pivot0": pymunk.PivotJoint(ground, bodies["rocker0"], (0.0, 0.0), (-0.5, 0.0)),
        "left0": pymunk.PivotJoint(bodies["rocker0"], bodies["bar0"], (0.5, 0.0), (-0.5, 0.0)),
        "right0": pymunk.PivotJoint(bodies["bar0"], bodies["rocker1"], (0.5, 0.0), (0.5, 0.0)),
        "left1": pymunk.PivotJoint(bodies["rocker1"], bodies["bar1"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot1": pymunk.PivotJoint(ground, bodies["rocker1"], (1.0, 0.0), (-0.5, 0.0)),
        "right1": pymunk.PivotJoint(bodies["bar1"], bodies["rocker2"], (0.5, 0.0), (0.5, 0.0)),
        "left2": pymunk.PivotJoint(bodies["rocker2"], bodies["bar2"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot2": pymunk.PivotJoint(ground, bodies["rocker2"], (2.0, 0.0), (-0.5, 0.0)),
        "right2": pymunk.PivotJoint(bodies["bar2"], bodies["rocker3"], (0.5, 0.0), (0.5, 0.0)),
        "left3": pymunk.PivotJoint(bodies["rocker3"], bodies["bar3"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot3": pymunk.PivotJoint(ground, bodies["rocker3"], (3.0, 0.0), (-0.5, 0.0)),
        "right3": pymunk.PivotJoint(bodies["bar3"], bodies["rocker4"], (0.5, 0.0), (0.5, 0.0)),
        "left4": pymunk.PivotJoint(bodies["rocker4"], bodies["bar4"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot4": pymunk.PivotJoint(ground, bodies["rocker4"], (4.0, 0.0), (-0.5, 0.0)),
        "right4": pymunk.PivotJoint(bodies["bar4"], bodies["rocker5"], (0.5, 0.0), (0.5, 0.0)),
        "left5": pymunk.PivotJoint(bodies["rocker5"], bodies["bar5"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot5": pymunk.PivotJoint(ground, bodies["rocker5"], (5.0, 0.0), (-0.5, 0.0)),
        "right5": pymunk.PivotJoint(bodies["bar5"], bodies["rocker6"], (0.5, 0.0), (0.5, 0.0)),
        "left6": pymunk.PivotJoint(bodies["rocker6"], bodies["bar6"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot6": pymunk.PivotJoint(ground, bodies["rocker6"], (6.0, 0.0), (-0.5, 0.0)),
        "right6": pymunk.PivotJoint(bodies["bar6"], bodies["rocker7"], (0.5, 0.0), (0.5, 0.0)),
        "left7": pymunk.PivotJoint(bodies["rocker7"], bodies["bar7"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot7": pymunk.PivotJoint(ground, bodies["rocker7"], (7.0, 0.0), (-0.5, 0.0)),
        "right7": pymunk.PivotJoint(bodies["bar7"], bodies["rocker8"], (0.5, 0.0), (0.5, 0.0)),
        "left8": pymunk.PivotJoint(bodies["rocker8"], bodies["bar8"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot8": pymunk.PivotJoint(ground, bodies["rocker8"], (8.0, 0.0), (-0.5, 0.0)),
        "right8": pymunk.PivotJoint(bodies["bar8"], bodies["rocker9"], (0.5, 0.0), (0.5, 0.0)),
        "left9": pymunk.PivotJoint(bodies["rocker9"], bodies["bar9"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot9": pymunk.PivotJoint(ground, bodies["rocker9"], (9.0, 0.0), (-0.5, 0.0)),
        "right9": pymunk.PivotJoint(bodies["bar9"], bodies["rocker10"], (0.5, 0.0), (0.5, 0.0)),
        "left10": pymunk.PivotJoint(bodies["rocker10"], bodies["bar10"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot10": pymunk.PivotJoint(ground, bodies["rocker10"], (10.0, 0.0), (-0.5, 0.0)),
        "right10": pymunk.PivotJoint(bodies["bar10"], bodies["rocker11"], (0.5, 0.0), (0.5, 0.0)),
        "left11": pymunk.PivotJoint(bodies["rocker11"], bodies["bar11"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot11": pymunk.PivotJoint(ground, bodies["rocker11"], (11.0, 0.0), (-0.5, 0.0)),
        "right11": pymunk.PivotJoint(bodies["bar11"], bodies["rocker12"], (0.5, 0.0), (0.5, 0.0)),
        "left12": pymunk.PivotJoint(bodies["rocker12"], bodies["bar12"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot12": pymunk.PivotJoint(ground, bodies["rocker12"], (12.0, 0.0), (-0.5, 0.0)),
        "right12": pymunk.PivotJoint(bodies["bar12"], bodies["rocker13"], (0.5, 0.0), (0.5, 0.0)),
        "left13": pymunk.PivotJoint(bodies["rocker13"], bodies["bar13"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot13": pymunk.PivotJoint(ground, bodies["rocker13"], (13.0, 0.0), (-0.5, 0.0)),
        "right13": pymunk.PivotJoint(bodies["bar13"], bodies["rocker14"], (0.5, 0.0), (0.5, 0.0)),
        "left14": pymunk.PivotJoint(bodies["rocker14"], bodies["bar14"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot14": pymunk.PivotJoint(ground, bodies["rocker14"], (14.0, 0.0), (-0.5, 0.0)),
        "right14": pymunk.PivotJoint(bodies["bar14"], bodies["rocker15"], (0.5, 0.0), (0.5, 0.0)),
        "left15": pymunk.PivotJoint(bodies["rocker15"], bodies["bar15"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot15": pymunk.PivotJoint(ground, bodies["rocker15"], (15.0, 0.0), (-0.5, 0.0)),
        "right15": pymunk.PivotJoint(bodies["bar15"], bodies["rocker16"], (0.5, 0.0), (0.5, 0.0)),
        "left16": pymunk.PivotJoint(bodies["rocker16"], bodies["bar16"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot16": pymunk.PivotJoint(ground, bodies["rocker16"], (16.0, 0.0), (-0.5, 0.0)),
        "right16": pymunk.PivotJoint(bodies["bar16"], bodies["rocker17"], (0.5, 0.0), (0.5, 0.0)),
        "left17": pymunk.PivotJoint(bodies["rocker17"], bodies["bar17"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot17": pymunk.PivotJoint(ground, bodies["rocker17"], (17.0, 0.0), (-0.5, 0.0)),
        "right17": pymunk.PivotJoint(bodies["bar17"], bodies["rocker18"], (0.5, 0.0), (0.5, 0.0)),
        "left18": pymunk.PivotJoint(bodies["rocker18"], bodies["bar18"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot18": pymunk.PivotJoint(ground, bodies["rocker18"], (18.0, 0.0), (-0.5, 0.0)),
        "right18": pymunk.PivotJoint(bodies["bar18"], bodies["rocker19"], (0.5, 0.0), (0.5, 0.0)),
        "left19": pymunk.PivotJoint(bodies["rocker19"], bodies["bar19"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot19": pymunk.PivotJoint(ground, bodies["rocker19"], (19.0, 0.0), (-0.5, 0.0)),
        "right19": pymunk.PivotJoint(bodies["bar19"], bodies["rocker20"], (0.5, 0.0), (0.5, 0.0)),
        "left20": pymunk.PivotJoint(bodies["rocker20"], bodies["bar20"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot20": pymunk.PivotJoint(ground, bodies["rocker20"], (20.0, 0.0), (-0.5, 0.0)),
        "right20": pymunk.PivotJoint(bodies["bar20"], bodies["rocker21"], (0.5, 0.0), (0.5, 0.0)),
        "left21": pymunk.PivotJoint(bodies["rocker21"], bodies["bar21"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot21": pymunk.PivotJoint(ground, bodies["rocker21"], (21.0, 0.0), (-0.5, 0.0)),
        "right21": pymunk.PivotJoint(bodies["bar21"], bodies["rocker22"], (0.5, 0.0), (0.5, 0.0)),
        "left22": pymunk.PivotJoint(bodies["rocker22"], bodies["bar22"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot22": pymunk.PivotJoint(ground, bodies["rocker22"], (22.0, 0.0), (-0.5, 0.0)),
        "right22": pymunk.PivotJoint(bodies["bar22"], bodies["rocker23"], (0.5, 0.0), (0.5, 0.0)),
        "left23": pymunk.PivotJoint(bodies["rocker23"], bodies["bar23"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot23": pymunk.PivotJoint(ground, bodies["rocker23"], (23.0, 0.0), (-0.5, 0.0)),
        "right23": pymunk.PivotJoint(bodies["bar23"], bodies["rocker24"], (0.5, 0.0), (0.5, 0.0)),
        "left24": pymunk.PivotJoint(bodies["rocker24"], bodies["bar24"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot24": pymunk.PivotJoint(ground, bodies["rocker24"], (24.0, 0.0), (-0.5, 0.0)),
        "right24": pymunk.PivotJoint(bodies["bar24"], bodies["rocker25"], (0.5, 0.0), (0.5, 0.0)),
        "left25": pymunk.PivotJoint(bodies["rocker25"], bodies["bar25"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot25": pymunk.PivotJoint(ground, bodies["rocker25"], (25.0, 0.0), (-0.5, 0.0)),
        "right25": pymunk.PivotJoint(bodies["bar25"], bodies["rocker26"], (0.5, 0.0), (0.5, 0.0)),
        "left26": pymunk.PivotJoint(bodies["rocker26"], bodies["bar26"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot26": pymunk.PivotJoint(ground, bodies["rocker26"], (26.0, 0.0), (-0.5, 0.0)),
        "right26": pymunk.PivotJoint(bodies["bar26"], bodies["rocker27"], (0.5, 0.0), (0.5, 0.0)),
        "left27": pymunk.PivotJoint(bodies["rocker27"], bodies["bar27"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot27": pymunk.PivotJoint(ground, bodies["rocker27"], (27.0, 0.0), (-0.5, 0.0)),
        "right27": pymunk.PivotJoint(bodies["bar27"], bodies["rocker28"], (0.5, 0.0), (0.5, 0.0)),
        "left28": pymunk.PivotJoint(bodies["rocker28"], bodies["bar28"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot28": pymunk.PivotJoint(ground, bodies["rocker28"], (28.0, 0.0), (-0.5, 0.0)),
        "right28": pymunk.PivotJoint(bodies["bar28"], bodies["rocker29"], (0.5, 0.0), (0.5, 0.0)),
        "left29": pymunk.PivotJoint(bodies["rocker29"], bodies["bar29"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot29": pymunk.PivotJoint(ground, bodies["rocker29"], (29.0, 0.0), (-0.5, 0.0)),
        "right29": pymunk.PivotJoint(bodies["bar29"], bodies["rocker30"], (0.5, 0.0), (0.5, 0.0)),
        "left30": pymunk.PivotJoint(bodies["rocker30"], bodies["bar30"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot30": pymunk.PivotJoint(ground, bodies["rocker30"], (30.0, 0.0), (-0.5, 0.0)),
        "right30": pymunk.PivotJoint(bodies["bar30"], bodies["rocker31"], (0.5, 0.0), (0.5, 0.0)),
        "left31": pymunk.PivotJoint(bodies["rocker31"], bodies["bar31"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot31": pymunk.PivotJoint(ground, bodies["rocker31"], (31.0, 0.0), (-0.5, 0.0)),
        "right31": pymunk.PivotJoint(bodies["bar31"], bodies["rocker32"], (0.5, 0.0), (0.5, 0.0)),
        "left32": pymunk.PivotJoint(bodies["rocker32"], bodies["bar32"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot32": pymunk.PivotJoint(ground, bodies["rocker32"], (32.0, 0.0), (-0.5, 0.0)),
        "right32": pymunk.PivotJoint(bodies["bar32"], bodies["rocker33"], (0.5, 0.0), (0.5, 0.0)),
        "left33": pymunk.PivotJoint(bodies["rocker33"], bodies["bar33"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot33": pymunk.PivotJoint(ground, bodies["rocker33"], (33.0, 0.0), (-0.5, 0.0)),
        "right33": pymunk.PivotJoint(bodies["bar33"], bodies["rocker34"], (0.5, 0.0), (0.5, 0.0)),
        "left34": pymunk.PivotJoint(bodies["rocker34"], bodies["bar34"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot34": pymunk.PivotJoint(ground, bodies["rocker34"], (34.0, 0.0), (-0.5, 0.0)),
        "right34": pymunk.PivotJoint(bodies["bar34"], bodies["rocker35"], (0.5, 0.0), (0.5, 0.0)),
        "left35": pymunk.PivotJoint(bodies["rocker35"], bodies["bar35"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot35": pymunk.PivotJoint(ground, bodies["rocker35"], (35.0, 0.0), (-0.5, 0.0)),
        "right35": pymunk.PivotJoint(bodies["bar35"], bodies["rocker36"], (0.5, 0.0), (0.5, 0.0)),
        "left36": pymunk.PivotJoint(bodies["rocker36"], bodies["bar36"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot36": pymunk.PivotJoint(ground, bodies["rocker36"], (36.0, 0.0), (-0.5, 0.0)),
        "right36": pymunk.PivotJoint(bodies["bar36"], bodies["rocker37"], (0.5, 0.0), (0.5, 0.0)),
        "left37": pymunk.PivotJoint(bodies["rocker37"], bodies["bar37"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot37": pymunk.PivotJoint(ground, bodies["rocker37"], (37.0, 0.0), (-0.5, 0.0)),
        "right37": pymunk.PivotJoint(bodies["bar37"], bodies["rocker38"], (0.5, 0.0), (0.5, 0.0)),
        "left38": pymunk.PivotJoint(bodies["rocker38"], bodies["bar38"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot38": pymunk.PivotJoint(ground, bodies["rocker38"], (38.0, 0.0), (-0.5, 0.0)),
        "right38": pymunk.PivotJoint(bodies["bar38"], bodies["rocker39"], (0.5, 0.0), (0.5, 0.0)),
        "left39": pymunk.PivotJoint(bodies["rocker39"], bodies["bar39"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot39": pymunk.PivotJoint(ground, bodies["rocker39"], (39.0, 0.0), (-0.5, 0.0)),
        "right39": pymunk.PivotJoint(bodies["bar39"], bodies["rocker40"], (0.5, 0.0), (0.5, 0.0)),
        "pivot40": pymunk.PivotJoint(ground, bodies["rocker40"], (40.0, 0.0), (-0.5, 0.0)),
    }
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "tip": ("rocker0", (0.5, 0.0)),
    }
    return Model(space, bodies, constraints, points)


def step(model):
    """Advance a model by one time step."""
    if model.steps == 0:
        _start_between_steps(model)
    model.space.step(model.timestep)
    model.steps += 1


def _start_between_steps(model):
    """Advance the velocities by half a step: pymunk's belong to the middle between two steps."""
    for body in model.bodies.values():
        body.position -= 0.5 * model.timestep * body.velocity
        body.angle -= 0.5 * model.timestep * body.angular_velocity
    model.space.step(0.5 * model.timestep)


def travel(path):
    """Largest distance [m] between two positions of a path: along the line through the farthest of a few hundred."""
    few = path[:: max(1, len(path) // 300)]
    (ax, ay), (bx, by) = max(((a, b) for a in few for b in few), key=lambda pair: math.dist(*pair))
    length = math.dist((ax, ay), (bx, by))
    if length == 0.0:
        return 0.0
    along = [(x * (bx - ax) + y * (by - ay)) / length for x, y in path]
    return max(along) - min(along)


def main():
    """Run 12.5664 s, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in 12.5664 s")


if __name__ == "__main__":
    main()
