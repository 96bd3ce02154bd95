(* ---- Inequalities on the unit circle, z = N / Q with N = 1 - w^2 + 2 i w and Q = 1 + w^2, by polynomials of w ---- *)

Definition cpoly := (list Z * list Z)%type.
Definition cev (P : cpoly) (w : R) : C := (peval (fst P) w, peval (snd P) w).
Definition cp_add (P S : cpoly) : cpoly := (add (fst P) (fst S), add (snd P) (snd S)).
Definition cp_mul (P S : cpoly) : cpoly :=
  (add (pmul (fst P) (fst S)) (scale (-1) (pmul (snd P) (snd S))), add (pmul (fst P) (snd S)) (pmul (snd P) (fst S))).
Definition cp_scale (c : Z) (P : cpoly) : cpoly := (scale c (fst P), scale c (snd P)).
Definition cp_conj (P : cpoly) : cpoly := (fst P, scale (-1) (snd P)).
Fixpoint cp_pow (P : cpoly) (n : nat) : cpoly := match n with O => ([1%Z], []) | S k => cp_mul P (cp_pow P k) end.
Definition top : cpoly := ([1; 0; -1], [0; 2])%Z.
Definition bottom_ : cpoly := ([1; 0; 1], [])%Z.
(* z^i times Q^m *)
Definition cp_z (m i : nat) : cpoly := cp_mul (cp_pow top i) (cp_pow bottom_ (m - i)).

Lemma cev_add : forall P S w, cev (cp_add P S) w = cadd (cev P w) (cev S w).
Proof. intros [a b] [c d] w; unfold cev, cp_add, cadd; cbn [fst snd]; now rewrite !peval_add. Qed.
Lemma cev_mul : forall P S w, cev (cp_mul P S) w = cmul (cev P w) (cev S w).
Proof.
  intros [a b] [c d] w; unfold cev, cp_mul, cmul; cbn [fst snd]; rewrite !peval_add, peval_scale, !peval_mul.
  f_equal; ring.
Qed.
Lemma cev_scale : forall c P w, cev (cp_scale c P) w = cmul (real (IZR c)) (cev P w).
Proof. intros c [a b] w; unfold cev, cp_scale, cmul, real; cbn [fst snd]; rewrite !peval_scale; f_equal; ring. Qed.
Lemma cev_conj : forall P w, cev (cp_conj P) w = conj_ (cev P w).
Proof. intros [a b] w; unfold cev, cp_conj, conj_; cbn [fst snd]; rewrite peval_scale; f_equal; ring. Qed.
Lemma creal : forall a b s, cmul (real a) (cmul (real b) s) = cmul (real (a * b)) s.
Proof. intros a b [x y]; unfold cmul, real; cbn [fst snd]; f_equal; ring. Qed.
Lemma cev_bottom : forall n w, cev (cp_pow bottom_ n) w = real ((1 + w * w) ^ n).
Proof.
  induction n as [|n IH]; intro w; [unfold cev, real; cbn; f_equal; ring|].
  cbn [cp_pow]; rewrite cev_mul, IH; unfold cev, bottom_, cmul, real; cbn [fst snd peval pow]; f_equal; ring.
Qed.
Lemma cev_top : forall n w, cev (cp_pow top n) w = cmul (real ((1 + w * w) ^ n)) (cpow (circle w) n).
Proof.
  intros n w; assert (pos : 0 < 1 + w * w) by nra; induction n as [|n IH]; [unfold cev, cmul, real; cbn; f_equal; ring|].
  cbn [cp_pow cpow]; rewrite cev_mul, IH; destruct (cpow (circle w) n) as [u v].
  unfold cev, top, circle, cmul, real; cbn [fst snd peval pow]; f_equal; field; lra.
Qed.
Lemma cev_z : forall m i w, (i <= m)%nat -> cev (cp_z m i) w = cmul (real ((1 + w * w) ^ m)) (cpow (circle w) i).
Proof.
  intros m i w L; unfold cp_z; rewrite cev_mul, cev_top, cev_bottom.
  replace m with (i + (m - i))%nat at 2 by lia; rewrite pow_add; destruct (cpow (circle w) i) as [u v].
  unfold cmul, real; cbn [fst snd]; f_equal; ring.
Qed.

(* A polynomial of z, the highest coefficient first, times Q^m. *)
Fixpoint cp_poly (m : nat) (p : list Z) : cpoly :=
  match p with c :: r => cp_add (cp_scale c (cp_z m (length r))) (cp_poly m r) | [] => ([], []) end.
Fixpoint power_sum (p : list Z) (s : C) : C :=
  match p with c :: r => cadd (cmul (real (IZR c)) (cpow s (length r))) (power_sum r s) | [] => (0, 0) end.
Lemma cev_poly : forall m p w, (length p <= S m)%nat ->
  cev (cp_poly m p) w = cmul (real ((1 + w * w) ^ m)) (power_sum p (circle w)).
Proof.
  intros m p w; induction p as [|c p IH]; intro L; cbn [length] in L.
  - unfold cev, cmul, real; cbn; f_equal; ring.
  - cbn [cp_poly power_sum]; rewrite cev_add, cev_scale, cev_z, IH by lia.
    destruct (cpow (circle w) (length p)) as [u v], (power_sum p (circle w)) as [x y].
    unfold cadd, cmul, real; cbn [fst snd]; f_equal; ring.
Qed.

(* h (1 - sum c z^-i), or z^i, times Q^m, of taps c / h. *)
Definition tap_of (h : Z) (t : Z * nat * bool) : tap := match t with (c, i, causal) => (IZR c / IZR h, i, causal) end.
Lemma same_tap : forall c d i causal (r s : list tap), c = d -> r = s -> (c, i, causal) :: r = (d, i, causal) :: s.
Proof. intros c d i causal r s -> ->; reflexivity. Qed.
Fixpoint cp_taps (m : nat) (ts : list (Z * nat * bool)) : cpoly :=
  match ts with
  | (c, i, causal) :: r =>
      cp_add (cp_scale (- c) (if causal then cp_conj (cp_z m i) else cp_z m i)) (cp_taps m r)
  | [] => ([], [])
  end.
Lemma cev_taps : forall m h ts w, (0 < h)%Z -> Forall (fun t => (snd (fst t) <= m)%nat) ts ->
  cev (cp_taps m ts) w = cmul (real ((1 + w * w) ^ m * IZR h)) (taps (map (tap_of h) ts) w).
Proof.
  intros m h ts w H F; apply IZR_lt in H; induction F as [|[[c i] causal] ts L F IH].
  - unfold cev, cmul, real; cbn; f_equal; ring.
  - cbn [cp_taps taps map tap_of fst snd] in *; rewrite cev_add, cev_scale, IH.
    assert (E : cev (if causal then cp_conj (cp_z m i) else cp_z m i) w
      = cmul (real ((1 + w * w) ^ m)) (if causal then conj_ (cpow (circle w) i) else cpow (circle w) i)).
    { destruct causal; rewrite ?cev_conj, cev_z by exact L; [|reflexivity].
      destruct (cpow (circle w) i) as [u v]; unfold conj_, cmul, real; cbn [fst snd]; f_equal; ring. }
    rewrite E; destruct (if causal then _ else _) as [u v], (taps (map (tap_of h) ts) w) as [x y].
    unfold cadd, cmul, real; cbn [fst snd]; rewrite opp_IZR; f_equal; field; lra.
Qed.

Definition samples_of (m T : nat) (X D : cpoly) : list cpoly :=
  map (fun i => cp_mul (cp_z m i) D) (seq 0 T) ++ map (fun i => cp_mul (cp_z m i) (cp_scale (-1) X)) (seq 0 T).
Fixpoint pdot (row : list Z) (ps : list (list Z)) : list Z :=
  match row, ps with a :: row', p :: ps' => add (scale a p) (pdot row' ps') | _, _ => [] end.
Fixpoint pform (M : list (list Z)) (us ps : list (list Z)) : list Z :=
  match M, us with row :: M', u :: us' => add (pmul u (pdot row ps)) (pform M' us' ps) | _, _ => [] end.
Lemma peval_pdot : forall row ps w, peval (pdot row ps) w = dot row (map (fun p => peval p w) ps).
Proof.
  induction row as [|a row IH]; intros [|p ps] w; cbn [pdot peval dot map]; try reflexivity.
  now rewrite peval_add, peval_scale, IH.
Qed.
Lemma peval_pform : forall M us ps w,
  peval (pform M us ps) w = sumprod (map (fun p => peval p w) us) (map (fun row => dot row (map (fun p => peval p w) ps)) M).
Proof.
  induction M as [|row M IH]; intros [|u us] ps w; cbn [pform peval map sumprod]; try reflexivity.
  now rewrite peval_add, peval_mul, peval_pdot, IH.
Qed.

(* Coefficients of even powers, all others being 0. *)
Fixpoint evens (p : list Z) : option (list Z) :=
  match p with
  | a :: b :: r => if (b =? 0)%Z then option_map (cons a) (evens r) else None
  | [a] => Some [a]
  | [] => Some []
  end.
Lemma evens_sound : forall n p q x, (length p <= n)%nat -> evens p = Some q -> peval p x = peval q (x * x).
Proof.
  induction n as [|n IH]; intros [|a [|b r]] q x L E; cbn [evens length] in *; try lia;
    try (injection E as <-; cbn [peval]; ring).
  destruct (Z.eqb_spec b 0) as [->|]; [|discriminate]; destruct (evens r) as [s|] eqn:F; [|discriminate].
  injection E as <-; cbn [peval]; rewrite (IH r s x ltac:(lia) F); ring.
Qed.

(* XZ and DZ are c times den + k num and den + l num.  More of Q than the taps, or than the samples, need: a, b. *)
Definition circle_polynomial (n m a T b : nat) (h q e1 e2 : Z) (XZ DZ : list Z) (ts : list (Z * nat * bool))
    (M : list (list Z)) : list Z :=
  let X := cp_poly n XZ in let D := cp_poly n DZ in
  let W := samples_of T T X D in
  let Qa := fst (cp_pow bottom_ a) in let Qb := fst (cp_pow bottom_ b) in
  let first := fst (cp_mul (cp_add (cp_scale h (cp_pow bottom_ m)) (cp_taps m ts)) (cp_mul X (cp_conj D))) in
  let second := add (pform M (map fst W) (map fst W)) (pform M (map snd W) (map snd W)) in
  let square_ := fst (cp_mul D (cp_conj D)) in
  add (scale e2 (add (scale q (pmul Qa first)) (scale (- h) (pmul Qb second))))
      (scale (- e1) (pmul (fst (cp_pow bottom_ (m + a))) square_)).
Definition circle_test (n m a T b : nat) (h q e1 e2 : Z) (XZ DZ : list Z) (ts : list (Z * nat * bool))
    (M : list (list Z)) (t : tree) : bool :=
  (0 <? h)%Z && (0 <? q)%Z && (0 <? e1)%Z && (0 <? e2)%Z && (length XZ <=? S n)%nat && (length DZ <=? S n)%nat &&
  forallb (fun t => (snd (fst t) <=? m)%nat) ts && (m + a =? 2 * T + b)%nat &&
  match evens (circle_polynomial n m a T b h q e1 e2 XZ DZ ts M) with Some p => positive p t | None => false end.

Theorem circle_sound : forall n m a T b h q e1 e2 XZ DZ ts M t num den l k c,
  circle_test n m a T b h q e1 e2 XZ DZ ts M t = true -> 0 < c ->
  (forall s, power_sum XZ s = cmul (real c) (closed num den k s)) ->
  (forall s, power_sum DZ s = cmul (real c) (closed num den l s)) ->
  over_frequencies circle (order_cone (IZR q) M T (map (tap_of h) ts)) num den l k.
Proof.
  intros n m a T b h q e1 e2 XZ DZ ts M t num den l k c test cpos EX ED; unfold circle_test in test.
  rewrite !andb_true_iff, !Z.ltb_lt, !Nat.leb_le, Nat.eqb_eq in test.
  destruct test as [[[[[[[[H Q] E1] E2] LX] LD] LT] K] test].
  destruct (evens _) as [p|] eqn:F in test; [|discriminate].
  pose proof (IZR_lt _ _ H); pose proof (IZR_lt _ _ Q); pose proof (IZR_lt _ _ E1); pose proof (IZR_lt _ _ E2).
  exists (IZR e1 / (IZR e2 * (IZR h * IZR q))); split.
  { apply Rdiv_lt_0_compat; [assumption|]; repeat apply Rmult_lt_0_compat; assumption. }
  intros w W; pose proof (positive_sound t p (w * w) test ltac:(nra)) as pos.
  rewrite <- (evens_sound _ _ p w (le_n _) F) in pos; unfold circle_polynomial in pos; cbv zeta in pos.
  set (X := cp_poly n XZ) in *; set (D := cp_poly n DZ) in *.
  set (y := 1 + w * w); assert (ypos : 0 < y) by (unfold y; nra).
  assert (VX : cev X w = cmul (real (y ^ n * c)) (closed num den k (circle w))).
  { unfold X; rewrite cev_poly, EX, creal by exact LX; reflexivity. }
  assert (VD : cev D w = cmul (real (y ^ n * c)) (closed num den l (circle w))).
  { unfold D; rewrite cev_poly, ED, creal by exact LD; reflexivity. }
  assert (VT : cev (cp_add (cp_scale h (cp_pow bottom_ m)) (cp_taps m ts)) w
    = cmul (real (y ^ m * IZR h)) (zames_falb_steps (map (tap_of h) ts) w)).
  { rewrite cev_add, cev_scale, cev_bottom, (cev_taps m h).
    - unfold zames_falb_steps; destruct (taps (map (tap_of h) ts) w) as [u v].
      fold y; unfold cadd, cmul, real; cbn [fst snd]; f_equal; ring.
    - exact H.
    - apply Forall_forall; rewrite forallb_forall in LT; intros s I; apply Nat.leb_le; now apply LT. }
  set (cX := closed num den k (circle w)) in *; set (cD := closed num den l (circle w)) in *.
  set (m_ := zames_falb_steps (map (tap_of h) ts) w) in *.
  (* the samples *)
  set (Ws := map (fun i => cmul (cpow (circle w) i) cD) (seq 0 T)
    ++ map (fun i => cmul (cpow (circle w) i) (cmul (-1, 0) cX)) (seq 0 T)).
  assert (VW : map (fun P => cev P w) (samples_of T T X D) = map (cmul (real (y ^ T * (y ^ n * c)))) Ws).
  { unfold samples_of, Ws; rewrite !map_app, !map_map; f_equal; apply map_ext_in; intros i I; apply in_seq in I;
      rewrite cev_mul, cev_z by lia; fold y; rewrite ?cev_scale, ?VX, ?VD;
      destruct (cpow (circle w) i) as [u v], cX as [x1 x2], cD as [d1 d2]; unfold cmul, real; cbn [fst snd];
      f_equal; ring. }
  assert (part : forall g (f : cpoly -> list Z), (forall P, peval (f P) w = g (cev P w)) ->
    (forall r s, g (cmul (real r) s) = r * g s) ->
    peval (pform M (map f (samples_of T T X D)) (map f (samples_of T T X D))) w
    = (y ^ T * (y ^ n * c)) ^ 2 * V M (map g Ws)).
  { intros g f G L; rewrite peval_pform, !map_map.
    assert (R1 : map (fun P => peval (f P) w) (samples_of T T X D) = map (Rmult (y ^ T * (y ^ n * c))) (map g Ws)).
    { rewrite (map_ext _ (fun P => g (cev P w))) by (intro; apply G).
      rewrite <- (map_map (fun P => cev P w) g), VW, !map_map; apply map_ext; intro s; apply L. }
    rewrite R1; unfold V; generalize (map g Ws); intro zs.
    assert (DL : forall row r us, dot row (map (Rmult r) us) = r * dot row us).
    { induction row as [|a0 row IH]; intros r [|x us]; cbn [dot map]; try ring; rewrite IH; ring. }
    rewrite (map_ext (fun row => dot row (map (Rmult (y ^ T * (y ^ n * c))) zs))
      (fun row => (y ^ T * (y ^ n * c)) * dot row zs)) by (intro; apply DL).
    generalize M at 1 2 as M'; generalize zs at 1 3 as us; induction us as [|x us IH]; intros [|row M']; cbn [sumprod map]; try ring.
    rewrite IH; ring. }
  pose proof (part fst fst (fun P => eq_refl)) as P1; pose proof (part snd snd (fun P => eq_refl)) as P2.
  specialize (P1 ltac:(intros r [u v]; unfold cmul, real; cbn [fst snd]; ring)).
  specialize (P2 ltac:(intros r [u v]; unfold cmul, real; cbn [fst snd]; ring)).
  assert (B : forall j, peval (fst (cp_pow bottom_ j)) w = y ^ j).
  { intro j; change (fst (cev (cp_pow bottom_ j) w) = y ^ j); rewrite cev_bottom; reflexivity. }
  assert (T1 : peval (fst (cp_mul (cp_add (cp_scale h (cp_pow bottom_ m)) (cp_taps m ts)) (cp_mul X (cp_conj D)))) w
    = y ^ m * IZR h * (y ^ n * c) ^ 2 * with_multiplier (zames_falb_steps (map (tap_of h) ts)) w cX cD).
  { match goal with |- peval (fst ?P) w = _ => change (fst (cev P w) = y ^ m * IZR h * (y ^ n * c) ^ 2
      * with_multiplier (zames_falb_steps (map (tap_of h) ts)) w cX cD) end.
    rewrite !cev_mul, VT, cev_conj, VX, VD; unfold with_multiplier; fold m_.
    destruct m_ as [u v], cX as [x1 x2], cD as [d1 d2]; unfold re, conj_, cmul, real; cbn [fst snd]; ring. }
  assert (T2 : peval (fst (cp_mul D (cp_conj D))) w = (y ^ n * c) ^ 2 * square cD).
  { match goal with |- peval (fst ?P) w = _ => change (fst (cev P w) = (y ^ n * c) ^ 2 * square cD) end.
    rewrite cev_mul, cev_conj, VD; destruct cD as [d1 d2]; unfold square, conj_, cmul, real; cbn [fst snd]; ring. }
  repeat (rewrite peval_add in pos || rewrite peval_scale in pos || rewrite peval_mul in pos).
  change (@map (list Z * list Z) (list Z)) with (@map cpoly (list Z)) in pos.
  rewrite !opp_IZR, !B, T1, T2, P1, P2 in pos.
  change (@map C R) with (@map (R * R) R) in pos; unfold order_cone; fold Ws.
  set (E := with_multiplier (zames_falb_steps (map (tap_of h) ts)) w cX cD) in *.
  set (form := V M (map fst Ws) + V M (map snd Ws)).
  assert (U : 0 < y ^ (m + a) * (y ^ n * c) ^ 2).
  { apply Rmult_lt_0_compat; [now apply pow_lt|]; apply pow_lt, Rmult_lt_0_compat; [now apply pow_lt|exact cpos]. }
  assert (S2 : y ^ b * (y ^ T * (y ^ n * c)) ^ 2 = y ^ (m + a) * (y ^ n * c) ^ 2).
  { rewrite K; replace (2 * T + b)%nat with (b + (T + T))%nat by lia; rewrite !pow_add; ring. }
  assert (S1 : y ^ a * (y ^ m * IZR h * (y ^ n * c) ^ 2 * E) = y ^ (m + a) * (y ^ n * c) ^ 2 * (IZR h * E)).
  { rewrite pow_add; ring. }
  assert (G : 0 < (y ^ (m + a) * (y ^ n * c) ^ 2)
    * (IZR e2 * (IZR q * (IZR h * E) - IZR h * form) - IZR e1 * square cD)).
  { replace (_ * (_ - _)) with (IZR e2 * (IZR q * (y ^ a * (y ^ m * IZR h * (y ^ n * c) ^ 2 * E))
      + - IZR h * (y ^ b * (y ^ T * (y ^ n * c)) ^ 2 * form)) + - IZR e1 * (y ^ (m + a) * ((y ^ n * c) ^ 2 * square cD)));
      [|rewrite S1, S2; ring].
    unfold form; apply Rlt_le_trans with (1 := pos); right; ring. }
  assert (G' : 0 < IZR e2 * (IZR q * (IZR h * E) - IZR h * form) - IZR e1 * square cD).
  { apply (Rmult_lt_reg_l (y ^ (m + a) * (y ^ n * c) ^ 2)); [exact U|lra]. }
  assert (R_ : 0 < IZR e2 * (IZR h * IZR q)) by (repeat apply Rmult_lt_0_compat; assumption).
  apply (Rmult_le_reg_l (IZR e2 * (IZR h * IZR q))); [exact R_|].
  replace (IZR e2 * (IZR h * IZR q) * (IZR e1 / (IZR e2 * (IZR h * IZR q)) * square cD)) with (IZR e1 * square cD)
    by (field; repeat split; lra).
  replace (IZR e2 * (IZR h * IZR q) * (E - form / IZR q)) with (IZR e2 * (IZR q * (IZR h * E) - IZR h * form))
    by (field; lra).
  lra.
Qed.
Lemma taps_alone : forall q hs num den l k, over_frequencies circle (order_cone q [] 0 hs) num den l k ->
  over_frequencies circle (with_multiplier (zames_falb_steps hs)) num den l k.
Proof.
  intros q hs num den l k [eps [e H]]; exists eps; split; [exact e|]; intros w W; pose proof (H w W) as G.
  unfold order_cone in G; cbn [seq map app V sumprod] in G; unfold V in G; cbn [sumprod map] in G.
  unfold Rdiv in G; rewrite Rplus_0_l, Rmult_0_l, Rminus_0_r in G; exact G.
Qed.
