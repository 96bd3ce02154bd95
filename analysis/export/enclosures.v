(* ---- Solutions of d x' = A x, enclosed step by step: Taylor's polynomials in integers, with an error for each weight ---- *)

Fixpoint zdot (g v : list Z) : Z := match g, v with a :: g', x :: v' => (a * x + zdot g' v')%Z | _, _ => 0%Z end.
Fixpoint weigh (g W : list Z) : Z := match g, W with a :: g', w :: W' => (Z.abs a * w + weigh g' W')%Z | _, _ => 0%Z end.
Definition within (W : list Z) (e : R) (z : list R) : Prop := forall k, Rabs (nth k z 0) <= IZR (nth k W 0%Z) * e.

Lemma weigh_nonneg : forall g W, Forall (fun w => 1 <= w)%Z W -> 0 <= IZR (weigh g W).
Proof.
  induction g as [|a g IH]; intros [|w W] P; cbn [weigh]; try lra; inversion P; subst.
  rewrite plus_IZR, mult_IZR, abs_IZR; specialize (IH W H2); apply IZR_le in H1; pose proof (Rabs_pos (IZR a)); nra.
Qed.
Lemma dot_within : forall g W e z, 0 <= e -> Forall (fun w => 1 <= w)%Z W -> length z = length W -> within W e z ->
  Rabs (dot g z) <= IZR (weigh g W) * e.
Proof.
  induction g as [|a g IH]; intros [|w W] e [|x z] e0 P L H; try discriminate; cbn [dot weigh]; try (rewrite Rabs_R0; lra).
  inversion P; subst; specialize (IH W e z e0 H3 ltac:(cbn in L; lia) (fun k => H (S k))); specialize (H 0%nat); cbn [nth] in H.
  apply Rle_trans with (1 := Rabs_triang _ _); rewrite plus_IZR, mult_IZR, abs_IZR, Rabs_mult; pose proof (Rabs_pos (IZR a)); nra.
Qed.

Lemma abs_both : forall x a, Rabs x <= a -> - a <= x <= a.
Proof. intros x a H; pose proof (Rle_abs x); pose proof (Rle_abs (- x)); rewrite Rabs_Ropp in *; lra. Qed.

(* f(u) <= C u^(m+1)/(m+1) where f' <= C u^m. *)
Lemma grow : forall g g' C m, (forall u, 0 <= u <= 1 -> derivable_pt_lim g u (g' u)) -> g 0 = 0 ->
  (forall u, 0 <= u <= 1 -> Rabs (g' u) <= C * u ^ m) -> forall u, 0 <= u <= 1 -> Rabs (g u) <= C * u ^ S m / INR (S m).
Proof.
  intros g g' C m D Z B u [[P|<-] Q]; [|rewrite Z, Rabs_R0, pow_i by lia; unfold Rdiv; lra].
  assert (N : INR (S m) <> 0) by (apply not_0_INR; lia).
  assert (at_s : forall s, s = 1 \/ s = -1 -> 0 <= C * u ^ S m / INR (S m) + s * g u).
  { intros s S0; destruct (MVT_cor2 (fun u => C / INR (S m) * u ^ S m + s * g u) (fun u => C * u ^ m + s * g' u) 0 u P)
      as [c [E c0]].
    - intros c c0; apply (derivable_pt_lim_plus (fun u => C / INR (S m) * u ^ S m) (fun u => s * g u));
        [|apply (derivable_pt_lim_scal g), D; lra].
      apply (derivable_same (fun u => C / INR (S m) * u ^ S m) _ c (C / INR (S m) * (INR (S m) * c ^ m)));
        [reflexivity|field; exact N|].
      apply (derivable_pt_lim_scal (fun u => u ^ S m)), (derivable_pt_lim_pow c (S m)).
    - rewrite Z, pow_i in E by lia; specialize (B c ltac:(lra)); apply abs_both in B.
      replace (C * u ^ S m / INR (S m) + s * g u) with ((C * c ^ m + s * g' c) * u) by (unfold Rdiv in *; lra).
      destruct S0 as [-> | ->]; nra. }
  pose proof (at_s 1 (or_introl eq_refl)); pose proof (at_s (-1) (or_intror eq_refl)); apply Rabs_le; lra.
Qed.

Definition nextr (A : list (list Z)) (c : R) (j : nat) (z : list R) : list R := map (fun r => c * dot r z / INR (S j)) A.
(* a / b, where powers of 2 in b cost no division. *)
Fixpoint halved (a : Z) (b : BinNums.positive) : Z :=
  match b with xH => a | xO c => halved (Z.div2 a) c | xI _ => (a / Zpos b)%Z end.
Lemma halved_div : forall b a, halved a b = (a / Zpos b)%Z.
Proof.
  induction b; intro a; cbn [halved]; [reflexivity| |now rewrite Z.div_1_r].
  rewrite IHb, Z.div2_div, Z.div_div by lia; reflexivity.
Qed.
Definition over_z (a b : Z) : Z := match b with Zpos c => halved a c | _ => (a / b)%Z end.
Lemma over_z_div : forall a b, over_z a b = (a / b)%Z.
Proof. intros a [|b|b]; try reflexivity; apply halved_div. Qed.
Definition nextz (A : list (list Z)) (p q : Z) (j : nat) (v : list Z) : list Z :=
  map (fun r => over_z (p * zdot r v) (q * Z.of_nat (S j))) A.
Fixpoint terms_r (A : list (list Z)) (c : R) (m j : nat) (z : list R) : list (list R) :=
  match m with O => [z] | S i => z :: terms_r A c i (S j) (nextr A c j z) end.
Fixpoint terms_z (A : list (list Z)) (p q : Z) (m j : nat) (v : list Z) : list (list Z) :=
  match m with O => [v] | S i => v :: terms_z A p q i (S j) (nextz A p q j v) end.
Fixpoint along_r (g : list Z) (zs : list (list R)) (u : R) : R := match zs with z :: r => dot g z + u * along_r g r u | [] => 0 end.
Definition along_z (g : list Z) (vs : list (list Z)) : list Z := map (zdot g) vs.
Definition less (z : list R) (v : list Z) : list R := listed (length z) (fun k => nth k z 0 - IZR (nth k v 0%Z)).

Lemma dot_less : forall g z v, length z = length v -> dot g z - IZR (zdot g v) = dot g (less z v).
Proof.
  unfold less, listed; induction g as [|a g IH]; intros [|x z] [|y v] L; try discriminate; cbn [dot zdot length seq map]; try lra.
  rewrite plus_IZR, mult_IZR; cbn [nth]; rewrite <- seq_shift, map_map; cbn [nth]; rewrite <- IH by (cbn in L; lia); ring.
Qed.
Lemma nth_less : forall k z v, length z = length v -> nth k (less z v) 0 = nth k z 0 - IZR (nth k v 0%Z).
Proof.
  intros k z v L; unfold less, listed; destruct (Nat.lt_ge_cases k (length z)) as [K|K]; [now rewrite nth_listed|].
  rewrite !nth_overflow; rewrite ?map_length, ?seq_length; try lia; ring.
Qed.
Lemma nth_mapped : forall (X Y : Type) (f : X -> Y) l k a b, (k < length l)%nat -> nth k (map f l) b = f (nth k l a).
Proof. intros X Y f l k a b L; rewrite (nth_indep _ b (f a)) by (now rewrite map_length); apply map_nth. Qed.
Definition step_small (A : list (list Z)) (W : list Z) (p q : Z) : bool :=
  forallb (fun k => 2 * p * weigh (nth k A []) W <=? q * nth k W 0)%Z (seq 0 (length A)).
Lemma rounded_down : forall a b, (0 < b)%Z -> 0 <= IZR a / IZR b - IZR (a / b) <= 1.
Proof.
  intros a b P; pose proof (Z.div_mod a b ltac:(lia)) as E; pose proof (Z.mod_pos_bound a b P) as [L U].
  apply (f_equal IZR) in E; rewrite plus_IZR, mult_IZR in E; apply IZR_lt in P, U; apply IZR_le in L.
  replace (IZR a / IZR b) with (IZR (a / b) + IZR (a mod b) / IZR b) by (rewrite E; field; lra).
  assert (0 <= IZR (a mod b) / IZR b <= 1); [|lra].
  apply quotient; lra.
Qed.

Fixpoint divisor (m : nat) : Z := match m with O => 2 | S i => (2 * Z.of_nat (S m) * divisor i)%Z end.
Lemma divisor_pos : forall m, 0 < IZR (divisor m).
Proof. intro m; apply IZR_lt; induction m as [|m IH]; cbn [divisor]; lia. Qed.

Section Steps.
Variables (n : nat) (d : Z) (A : list (list Z)) (W : list Z) (p q : Z).
Hypotheses (d0 : (0 < d)%Z) (p0 : (0 < p)%Z) (q0 : (0 < q)%Z) (LA : length A = n) (LW : length W = n)
  (w1 : Forall (fun w => 1 <= w)%Z W) (small : step_small A W p q = true).
Let c := IZR p / IZR q.
Let h := IZR d * IZR p / IZR q.

Lemma c_pos : 0 < c.
Proof. apply Rdiv_lt_0_compat; now apply IZR_lt. Qed.
Lemma h_pos : 0 < h.
Proof. apply Rdiv_lt_0_compat; [apply Rmult_lt_0_compat|]; now apply IZR_lt. Qed.
Lemma weight_1 : forall k, (k < n)%nat -> 1 <= IZR (nth k W 0%Z).
Proof. intros k K; apply IZR_le; rewrite Forall_forall in w1; apply w1, nth_In; lia. Qed.
Lemma moved_within : forall e z k, length z = n -> within W e z -> 0 <= e -> (k < n)%nat ->
  Rabs (c * dot (nth k A []) z) <= IZR (nth k W 0%Z) * (e / 2).
Proof.
  intros e z k L H e0 K; rewrite Rabs_mult, (Rabs_right c) by (apply Rle_ge; left; apply c_pos).
  unfold step_small in small; rewrite forallb_forall in small; specialize (small k ltac:(apply in_seq; lia)).
  apply Z.leb_le, IZR_le in small; rewrite !mult_IZR in small.
  pose proof (dot_within (nth k A []) W e z e0 w1 ltac:(lia) H) as B; pose proof c_pos as C.
  apply Rle_trans with (c * (IZR (weigh (nth k A []) W) * e)); [apply Rmult_le_compat_l; lra|].
  assert (Q : 0 < IZR q) by now apply IZR_lt.
  replace (c * (IZR (weigh (nth k A []) W) * e)) with (2 * IZR p * IZR (weigh (nth k A []) W) * / IZR q * (e / 2)) by (unfold c; field; lra).
  apply Rmult_le_compat_r; [lra|]; apply (Rmult_le_reg_r (IZR q)); [exact Q|]; rewrite Rmult_assoc, Rinv_l; lra.
Qed.

(* Integers in place of the terms. *)
Lemma terms_near : forall g m j z v E, length z = n -> length v = n -> within W E (less z v) -> 0 <= E ->
  forall u, 0 <= u <= 1 ->
  Rabs (along_r g (terms_r A c m j z) u - peval (along_z g (terms_z A p q m j v)) u) <= IZR (weigh g W) * (2 * E + 2 * INR m).
Proof.
  intros g; pose proof (weigh_nonneg g W w1) as Wg; induction m as [|m IH]; intros j z v E Lz Lv H E0 u U;
    cbn [terms_r terms_z along_r along_z map peval];
    pose proof (dot_within g W E (less z v) E0 w1 ltac:(unfold less; rewrite listed_length; lia) H) as B;
    rewrite <- dot_less in B by congruence.
  - replace (dot g z + u * 0 - (IZR (zdot g v) + u * 0)) with (dot g z - IZR (zdot g v)) by ring; cbn [INR]; nra.
  - assert (N : within W (E / 2 + 1) (less (nextr A c j z) (nextz A p q j v))).
    { intro k; rewrite nth_less by (unfold nextr, nextz; now rewrite !map_length).
      destruct (Nat.lt_ge_cases k n) as [K|K].
      2: { rewrite !nth_overflow by (unfold nextr, nextz; rewrite ?map_length; lia); rewrite Rminus_0_r, Rabs_R0; lra. }
      unfold nextr, nextz; rewrite (nth_mapped _ _ _ A k []), (nth_mapped _ _ _ A k []), over_z_div by lia.
      set (r := nth k A []).
      pose proof (moved_within E (less z v) k ltac:(unfold less; rewrite listed_length; lia) H E0 K) as M; fold r in M.
      rewrite <- dot_less in M by congruence.
      pose proof (rounded_down (p * zdot r v) (q * Z.of_nat (S j)) ltac:(lia)) as Rd.
      rewrite !mult_IZR, <- INR_IZR_INZ in Rd.
      assert (J : 1 <= INR (S j)) by (apply (le_INR 1); lia); assert (Q : 0 < IZR q) by now apply IZR_lt.
      replace (IZR p * IZR (zdot r v) / (IZR q * INR (S j))) with (c * IZR (zdot r v) / INR (S j)) in Rd
        by (unfold c; field; lra).
      set (w := (p * zdot r v / (q * Z.of_nat (S j)))%Z) in *.
      replace (c * dot r z / INR (S j) - IZR w)
        with (c * (dot r z - IZR (zdot r v)) * / INR (S j) + (c * IZR (zdot r v) / INR (S j) - IZR w)) by (field; lra).
      apply Rle_trans with (1 := Rabs_triang _ _).
      rewrite Rabs_mult, (Rabs_right (/ INR (S j))) by (apply Rle_ge; left; apply Rinv_0_lt_compat; lra).
      rewrite (Rabs_right (c * IZR (zdot r v) / INR (S j) - IZR w)) by lra.
      assert (I1 : / INR (S j) <= 1) by (rewrite <- Rinv_1; apply Rinv_le_contravar; lra).
      pose proof (Rabs_pos (c * (dot r z - IZR (zdot r v)))); pose proof (weight_1 k K).
      assert (Rabs (c * (dot r z - IZR (zdot r v))) * / INR (S j) <= Rabs (c * (dot r z - IZR (zdot r v))) * 1) by (apply Rmult_le_compat_l; lra).
      lra. }
    assert (L1 : length (nextr A c j z) = n) by (unfold nextr; now rewrite map_length).
    assert (L2 : length (nextz A p q j v) = n) by (unfold nextz; now rewrite map_length).
    specialize (IH (S j) _ _ _ L1 L2 N ltac:(lra) u U); unfold along_z in IH.
    set (a := along_r g _ u) in *; set (b := peval _ u) in *; rewrite S_INR.
    replace (dot g z + u * a - (IZR (zdot g v) + u * b)) with ((dot g z - IZR (zdot g v)) + u * (a - b)) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite Rabs_mult, (Rabs_right u) by lra.
    pose proof (Rabs_pos (a - b)); assert (u * Rabs (a - b) <= 1 * Rabs (a - b)) by (apply Rmult_le_compat_r; lra); lra.
Qed.

(* A solution: what it is at most, and what is left of it beside m terms. *)
Variable f : nat -> R -> R.
Hypothesis flows : solves n d A f.

Lemma dot_listed : forall r a (X Y : nat -> R) m,
  dot r (listed m (fun k => a * X k + Y k)) = a * dot r (listed m X) + dot r (listed m Y).
Proof.
  intros r a X Y m; unfold listed; generalize (seq 0 m); induction r as [|x r IH]; intros [|k l]; cbn [map dot]; try ring.
  rewrite IH; ring.
Qed.
Lemma within_listed : forall e (F : nat -> R), (forall k, (k < n)%nat -> Rabs (F k) <= IZR (nth k W 0%Z) * e) -> within W e (listed n F).
Proof.
  intros e F H k; destruct (Nat.lt_ge_cases k n) as [K|K]; [unfold listed; rewrite nth_listed by exact K; now apply H|].
  rewrite !nth_overflow by (rewrite ?listed_length; lia); rewrite Rabs_R0; lra.
Qed.
Lemma in_step : forall k s u, (k < n)%nat ->
  derivable_pt_lim (fun u => f k (s + u * h)) u (c * dot (nth k A []) (at_once n f (s + u * h))).
Proof.
  intros k s u K; assert (D : 0 < IZR d) by (now apply IZR_lt); assert (Q : 0 < IZR q) by (now apply IZR_lt).
  apply (derivable_same (fun u => f k (s + u * h)) _ u (dot (nth k A []) (at_once n f (s + u * h)) / IZR d * h));
    [reflexivity|unfold h, c; field; lra|].
  apply (derivable_pt_lim_comp (fun u => s + u * h) (f k)); [|apply flows; exact K].
  apply (derivable_same (fun u => h * u + s) _ u (h * 1 + 0)); [intro; ring|ring|].
  apply (derivable_pt_lim_plus (fun u => h * u) (fun _ => s)); [|apply derivable_pt_lim_const].
  apply (derivable_pt_lim_scal id), derivable_pt_lim_id.
Qed.
Lemma some_bound : forall s j, (j <= n)%nat -> exists B, 0 <= B /\
  forall k u, (k < j)%nat -> 0 <= u <= 1 -> Rabs (f k (s + u * h)) <= B.
Proof.
  intros s; induction j as [|j IH]; intro J; [exists 0; split; [lra|intros; lia]|].
  destruct (IH ltac:(lia)) as [B [B0 H]].
  destruct (continuity_ab_maj (fun u => Rabs (f j (s + u * h))) 0 1 ltac:(lra)) as [u0 [M _]].
  { intros u _; apply (continuity_pt_comp (fun u => f j (s + u * h)) Rabs); [|apply Rcontinuity_abs].
    apply derivable_continuous_pt; eexists; apply in_step; lia. }
  exists (B + Rabs (f j (s + u0 * h))); pose proof (Rabs_pos (f j (s + u0 * h))); split; [lra|]; intros k u K U.
  destruct (Nat.eq_dec k j) as [->|ne]; [specialize (M u U); cbn in M; lra|specialize (H k u ltac:(lia) U); lra].
Qed.
Lemma bounded : forall s b, 0 <= b -> within W b (at_once n f s) -> forall u, 0 <= u <= 1 ->
  within W (2 * b) (at_once n f (s + u * h)).
Proof.
  intros s b b0 H u U; destruct (some_bound s n ltac:(lia)) as [B [B0 L]].
  assert (C : forall N k u, (k < n)%nat -> 0 <= u <= 1 -> Rabs (f k (s + u * h)) <= IZR (nth k W 0%Z) * (2 * b + B / 2 ^ N)).
  { induction N as [|N IH]; intros k v K V; pose proof (weight_1 k K) as w0.
    - specialize (L k v K V); cbn [pow]; nra.
    - assert (P : 0 < 2 ^ N) by (apply pow_lt; lra); assert (Q : 0 <= B / 2 ^ N) by (apply Rmult_le_pos; [lra|left; now apply Rinv_0_lt_compat]).
      pose proof (grow (fun u => f k (s + u * h) - f k s) (fun u => c * dot (nth k A []) (at_once n f (s + u * h)))
        (IZR (nth k W 0%Z) * ((2 * b + B / 2 ^ N) / 2)) 0) as G.
      specialize (G ltac:(intros w _; apply (derivable_same (fun u => f k (s + u * h) - f k s) _ w (c * dot (nth k A []) (at_once n f (s + w * h)) - 0));
        [reflexivity|ring|]; apply (derivable_pt_lim_minus (fun u => f k (s + u * h)) (fun _ => f k s)); [now apply in_step|apply derivable_pt_lim_const])).
      specialize (G ltac:(cbv beta; rewrite Rmult_0_l, Rplus_0_r; ring)).
      specialize (G ltac:(intros w w0'; cbn [pow]; rewrite Rmult_1_r; apply moved_within;
        [apply listed_length|apply within_listed; intros i I; now apply IH|lra|exact K]) v V).
      cbn [pow INR] in G; specialize (H k); unfold at_once, listed in H; rewrite nth_listed in H by exact K.
      replace (f k (s + v * h)) with (f k s + (f k (s + v * h) - f k s)) by ring; apply Rle_trans with (1 := Rabs_triang _ _).
      replace (B / 2 ^ S N) with (B / 2 ^ N / 2) by (cbn [pow]; field; lra).
      set (x := B / 2 ^ N) in *; apply Rle_trans with (1 := Rplus_le_compat _ _ _ _ H G).
      assert (0 <= IZR (nth k W 0%Z) * ((2 * b + x) / 2)) by (apply Rmult_le_pos; lra).
      assert (IZR (nth k W 0%Z) * ((2 * b + x) / 2) * v <= IZR (nth k W 0%Z) * ((2 * b + x) / 2) * 1) by (apply Rmult_le_compat_l; lra).
      unfold Rdiv in *; lra. }
  apply within_listed; intros k K; pose proof (weight_1 k K) as w0; apply le_epsilon; intros eps epos.
  destruct (cv_pow_half B (eps / IZR (nth k W 0%Z)) ltac:(apply Rdiv_lt_0_compat; lra)) as [N HN].
  specialize (HN N ltac:(lia)); specialize (C N k u K U); unfold R_dist in HN; rewrite Rminus_0_r in HN.
  pose proof (Rle_abs (B / 2 ^ N)); apply Rle_trans with (1 := C).
  assert (IZR (nth k W 0%Z) * (B / 2 ^ N) <= eps); [|lra].
  apply Rle_trans with (IZR (nth k W 0%Z) * (eps / IZR (nth k W 0%Z))); [apply Rmult_le_compat_l; lra|right; field; lra].
Qed.

Fixpoint term_r (j : nat) (z : list R) (i : nat) : list R := match i with O => z | S l => term_r (S j) (nextr A c j z) l end.
Lemma term_next : forall i j z, term_r j z (S i) = nextr A c (j + i) (term_r j z i).
Proof.
  induction i as [|i IH]; intros j z; [now rewrite Nat.add_0_r|].
  change (term_r j z (S (S i))) with (term_r (S j) (nextr A c j z) (S i)); rewrite IH, Nat.add_succ_r; reflexivity.
Qed.
Lemma term_length : forall i j z, length z = n -> length (term_r j z i) = n.
Proof. intros [|i] j z L; [exact L|]; rewrite term_next; unfold nextr; now rewrite map_length. Qed.
Lemma along_sum : forall g u m j z, along_r g (terms_r A c m j z) u = sum_f_R0 (fun i => dot g (term_r j z i) * u ^ i) m.
Proof.
  intros g u; induction m as [|m IH]; intros j z; cbn [terms_r along_r]; [cbn; ring|].
  rewrite IH, (decomp_sum (fun i => dot g (term_r j z i) * u ^ i)) by lia; cbn [pred term_r pow]; rewrite scal_sum; f_equal; [ring|].
  apply sum_eq; intros i _; ring.
Qed.
Lemma dot_sums : forall r (F : nat -> list R) u m, (forall i, length (F i) = n) ->
  sum_f_R0 (fun i => dot r (F i) * u ^ i) m = dot r (listed n (fun k => sum_f_R0 (fun i => nth k (F i) 0 * u ^ i) m)).
Proof.
  intros r F u m L.
  assert (E : forall i, dot r (F i) = dot r (listed n (fun k => nth k (F i) 0))) by (intro i; rewrite <- (L i), listed_again; reflexivity).
  induction m as [|m IH]; cbn [sum_f_R0].
  - rewrite E, <- (Rplus_0_r (_ * u ^ 0)), Rmult_comm.
    rewrite <- (Rplus_0_r (dot r (listed n (fun k => nth k (F 0%nat) 0 * u ^ 0)))).
    replace (listed n (fun k => nth k (F 0%nat) 0 * u ^ 0)) with (listed n (fun k => nth k (F 0%nat) 0)); [cbn; ring|].
    unfold listed; apply map_ext; intro; cbn; ring.
  - rewrite IH, E; set (X := fun k => nth k (F (S m)) 0); set (Y := fun k => sum_f_R0 (fun i => nth k (F i) 0 * u ^ i) m).
    rewrite Rplus_comm, (Rmult_comm (dot r _)), <- dot_listed; f_equal; unfold listed, X, Y; apply map_ext; intro; ring.
Qed.
Lemma remainder : forall s b, 0 <= b -> within W b (at_once n f s) -> forall m k u, (k < n)%nat -> 0 <= u <= 1 ->
  Rabs (f k (s + u * h) - sum_f_R0 (fun i => nth k (term_r 0 (at_once n f s) i) 0 * u ^ i) m)
    <= IZR (nth k W 0%Z) * (2 * b / IZR (divisor m)) * u ^ S m.
Proof.
  intros s b b0 H; set (z := at_once n f s) in *; assert (Lz : length z = n) by apply listed_length.
  assert (Z : forall k, (k < n)%nat -> nth k z 0 = f k s) by (intros k K; unfold z, at_once, listed; now rewrite nth_listed).
  induction m as [|m IH]; intros k u K U; pose proof (weight_1 k K) as w0.
  - pose proof (grow (fun u => f k (s + u * h) - sum_f_R0 (fun i => nth k (term_r 0 z i) 0 * u ^ i) 0)
      (fun u => c * dot (nth k A []) (at_once n f (s + u * h))) (IZR (nth k W 0%Z) * (2 * b / 2)) 0) as G.
    specialize (G ltac:(intros w _; apply (derivable_same (fun u => f k (s + u * h) - nth k z 0) _ w (c * dot (nth k A []) (at_once n f (s + w * h)) - 0));
      [intro; cbn; ring|ring|]; apply (derivable_pt_lim_minus (fun u => f k (s + u * h)) (fun _ => nth k z 0)); [now apply in_step|apply derivable_pt_lim_const])).
    specialize (G ltac:(cbn [sum_f_R0 term_r pow]; rewrite Rmult_0_l, Rplus_0_r, Z by exact K; ring)).
    specialize (G ltac:(intros w w1'; cbn [pow]; rewrite Rmult_1_r; apply moved_within;
        [apply listed_length|now apply bounded|lra|exact K]) u U).
    cbn [divisor]; apply Rle_trans with (1 := G); right; cbn; field.
  - pose proof (grow (fun u => f k (s + u * h) - sum_f_R0 (fun i => nth k (term_r 0 z i) 0 * u ^ i) (S m))
      (fun u => c * dot (nth k A []) (at_once n f (s + u * h)) - sum_f_R0 (fun i => c * dot (nth k A []) (term_r 0 z i) * u ^ i) m)
      (IZR (nth k W 0%Z) * (2 * b / IZR (divisor m) / 2)) (S m)) as G.
    assert (nextv : forall i, nth k (term_r 0 z (S i)) 0 = c * dot (nth k A []) (term_r 0 z i) / INR (S i)).
    { intro i; rewrite term_next; unfold nextr; rewrite (nth_mapped _ _ _ A k []) by lia; reflexivity. }
    specialize (G ltac:(intros w _; apply (derivable_pt_lim_minus (fun u => f k (s + u * h)) (fun u => sum_f_R0 (fun i => nth k (term_r 0 z i) 0 * u ^ i) (S m)));
      [now apply in_step|]; clear - nextv; induction m as [|m IH];
      [apply (derivable_same (fun u => nth k z 0 + nth k (term_r 0 z 1) 0 * u) _ w (0 + nth k (term_r 0 z 1) 0 * 1));
        [intro; cbn; ring|rewrite nextv; cbn; field|];
        apply (derivable_pt_lim_plus (fun _ => nth k z 0) (fun u => nth k (term_r 0 z 1) 0 * u)); [apply derivable_pt_lim_const|];
        apply (derivable_pt_lim_scal id), derivable_pt_lim_id
      |apply (derivable_pt_lim_plus (fun u => sum_f_R0 (fun i => nth k (term_r 0 z i) 0 * u ^ i) (S m))
          (fun u => nth k (term_r 0 z (S (S m))) 0 * u ^ S (S m))); [exact IH|];
        apply (derivable_same (fun u => nth k (term_r 0 z (S (S m))) 0 * u ^ S (S m)) _ w (nth k (term_r 0 z (S (S m))) 0 * (INR (S (S m)) * w ^ S m)));
        [reflexivity|rewrite nextv; field; apply not_0_INR; lia|];
        apply (derivable_pt_lim_scal (fun u => u ^ S (S m))), (derivable_pt_lim_pow w (S (S m)))])).
    specialize (G ltac:(cbv beta; rewrite decomp_sum by lia; cbn [pred term_r pow]; rewrite Rmult_0_l, Rplus_0_r, Z by exact K;
      rewrite (sum_eq _ (fun _ => 0)); [rewrite sum_cte; ring|intros; ring])).
    specialize (G ltac:(intros w w1'; cbv beta;
      replace (sum_f_R0 (fun i => c * dot (nth k A []) (term_r 0 z i) * w ^ i) m)
        with (c * sum_f_R0 (fun i => dot (nth k A []) (term_r 0 z i) * w ^ i) m) by (rewrite scal_sum; apply sum_eq; intros; ring);
      rewrite (dot_sums (nth k A []) (term_r 0 z) w m) by (intro; now apply term_length);
      match goal with |- Rabs (c * dot ?r (at_once n f ?t) - c * dot ?r (listed n ?Y)) <= _ =>
        replace (c * dot r (at_once n f t) - c * dot r (listed n Y))
          with (c * dot r (listed n (fun k => -1 * Y k + f k t))) by (rewrite dot_listed; unfold at_once; ring) end;
      apply Rle_trans with (IZR (nth k W 0%Z) * (2 * b / IZR (divisor m) * w ^ S m / 2)); [|right; field; pose proof (divisor_pos m); lra];
      apply moved_within; [apply listed_length|apply within_listed; intros i I|pose proof (divisor_pos m);
        apply Rmult_le_pos; [apply Rmult_le_pos; [lra|left; now apply Rinv_0_lt_compat]|apply pow_le; lra]|exact K];
      match goal with |- Rabs ?x <= _ => replace x with (f i (s + w * h) - sum_f_R0 (fun l => nth i (term_r 0 z l) 0 * w ^ l) m) by ring end;
      rewrite <- Rmult_assoc; now apply IH) u U).
    apply Rle_trans with (1 := G); right; change (divisor (S m)) with (2 * Z.of_nat (S (S m)) * divisor m)%Z.
    rewrite !mult_IZR, <- INR_IZR_INZ; field; pose proof (divisor_pos m); split; [lra|apply not_0_INR; lia].
Qed.
Theorem step_sound : forall s v e m, length v = n -> 0 <= e -> within W e (less (at_once n f s) v) ->
  2 * (IZR (row_size v) + e) <= IZR (divisor m) -> forall g u, 0 <= u <= 1 ->
  Rabs (dot g (at_once n f (s + u * h)) - peval (along_z g (terms_z A p q m 0 v)) u) <= IZR (weigh g W) * (2 * e + 2 * INR m + 1).
Proof.
  intros s v e m Lv e0 H T g u U; set (z := at_once n f s) in *; assert (Lz : length z = n) by apply listed_length.
  pose proof (row_size_nonneg v) as v0; set (b := IZR (row_size v) + e) in *.
  assert (B : within W b z).
  { intro k; destruct (Nat.lt_ge_cases k n) as [K|K]; [|rewrite !nth_overflow by lia; rewrite Rabs_R0; lra].
    specialize (H k); rewrite nth_less in H by congruence; pose proof (weight_1 k K).
    replace (nth k z 0) with (IZR (nth k v 0%Z) + (nth k z 0 - IZR (nth k v 0%Z))) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _).
    assert (V : Rabs (IZR (nth k v 0%Z)) <= IZR (row_size v)).
    { clear; revert k; induction v as [|a v IH]; intros [|k]; cbn [nth row_size]; try (rewrite Rabs_R0; lra);
        rewrite plus_IZR, abs_IZR; [pose proof (row_size_nonneg v); lra|specialize (IH k); pose proof (Rabs_pos (IZR a)); lra]. }
    unfold b; nra. }
  pose proof (terms_near g m 0 z v e Lz Lv H e0 u U) as N; rewrite along_sum, (dot_sums g (term_r 0 z) u m) in N by (intro; now apply term_length).
  set (P := fun k => sum_f_R0 (fun i => nth k (term_r 0 z i) 0 * u ^ i) m) in *.
  assert (R0 : Rabs (dot g (at_once n f (s + u * h)) - dot g (listed n P)) <= IZR (weigh g W) * 1).
  { replace (dot g (at_once n f (s + u * h)) - dot g (listed n P)) with (dot g (listed n (fun k => -1 * P k + f k (s + u * h))))
      by (rewrite dot_listed; unfold at_once; ring).
    apply dot_within; [lra|exact w1|rewrite listed_length; lia|apply within_listed; intros k K].
    replace (-1 * P k + f k (s + u * h)) with (f k (s + u * h) - P k) by ring.
    apply Rle_trans with (1 := remainder s b ltac:(unfold b; lra) B m k u K U); rewrite Rmult_assoc.
    apply Rmult_le_compat_l; [pose proof (weight_1 k K); lra|]; pose proof (divisor_pos m) as D.
    assert (0 <= u ^ S m <= 1) by (split; [apply pow_le; lra|rewrite <- (pow1 (S m)); apply pow_incr; lra]).
    assert (2 * b / IZR (divisor m) <= 1).
    { apply (Rmult_le_reg_r (IZR (divisor m))); [exact D|]; unfold Rdiv; rewrite Rmult_assoc, Rinv_l; lra. }
    assert (0 <= 2 * b / IZR (divisor m)) by (apply Rmult_le_pos; [unfold b; lra|left; now apply Rinv_0_lt_compat]).
    nra. }
  replace (dot g (at_once n f (s + u * h)) - peval (along_z g (terms_z A p q m 0 v)) u)
    with ((dot g (at_once n f (s + u * h)) - dot g (listed n P)) + (dot g (listed n P) - peval (along_z g (terms_z A p q m 0 v)) u)) by ring.
  apply Rle_trans with (1 := Rabs_triang _ _); lra.
Qed.
End Steps.
(* ---- Over many steps ---- *)

Definition stepped (A : list (list Z)) (p q : Z) (m : nat) (v : list Z) : list Z := fold_right add [] (terms_z A p q m 0 v).
Definition worse (m : nat) (e : Z) : Z := (2 * e + 2 * Z.of_nat m + 1)%Z.
Definition fits (m : nat) (v : list Z) (e : Z) : bool := (2 * (row_size v + e) <=? divisor m)%Z.
Fixpoint walk (A : list (list Z)) (p q : Z) (m K : nat) (v : list Z) (e : Z) : option (list Z) :=
  match K with O => Some v | S i => if fits m v e then walk A p q m i (stepped A p q m v) (worse m e) else None end.
Fixpoint worst (m K : nat) (e : Z) : Z := match K with O => e | S i => worst m i (worse m e) end.
Fixpoint trace (A : list (list Z)) (p q : Z) (m K : nat) (v : list Z) : list (list (list Z)) :=
  match K with O => [] | S i => let ts := terms_z A p q m 0 v in ts :: trace A p q m i (fold_right add [] ts) end.

(* A parabola below a polynomial on [0, 1], and what it is at least. *)
Definition lowest (p : list Z) : Z :=
  match p with
  | a :: b :: c :: r =>
      let k := (c + Z.min 0 (least r))%Z in
      if (k <=? 0)%Z then Z.min a (a + b + k) else if (0 <=? b)%Z then a
      else if (2 * k <=? - b)%Z then (a + b + k)%Z else (a - b * b / (4 * k) - 1)%Z
  | _ => least p
  end.
Lemma lowest_sound : forall p x, 0 <= x <= 1 -> IZR (lowest p) <= peval p x.
Proof.
  intros [|a [|b [|c r]]] x X; try (apply least_sound; exact X); unfold lowest; set (k := (c + Z.min 0 (least r))%Z).
  assert (B : IZR a + IZR b * x + IZR k * (x * x) <= peval (a :: b :: c :: r) x).
  { pose proof (least_sound r x X) as L; unfold k; rewrite plus_IZR; cbn [peval].
    assert (IZR (Z.min 0 (least r)) <= x * peval r x).
    { destruct (Z.min_spec 0 (least r)) as [[U E]|[U E]]; rewrite E;
      [apply IZR_lt in U; apply Rmult_le_pos; lra|apply IZR_le in U].
      assert (x * IZR (least r) <= x * peval r x) by (apply Rmult_le_compat_l; lra); nra. }
    assert (x * x * (IZR c + IZR (Z.min 0 (least r))) <= x * x * (IZR c + x * peval r x)) by (apply Rmult_le_compat_l; nra); lra. }
  apply Rle_trans with (2 := B); clear B; destruct (Z.leb_spec k 0) as [K|K].
  - apply IZR_le in K; assert (C : IZR k * x <= IZR k * (x * x)) by (apply Rmult_le_compat_neg_l; [exact K|nra]).
    destruct (Z.min_spec a (a + b + k)) as [[U E]|[U E]]; rewrite E; [apply IZR_lt in U|apply IZR_le in U];
      rewrite !plus_IZR in *; nra.
  - apply IZR_lt in K; destruct (Z.leb_spec 0 b) as [P|P]; [apply IZR_le in P; nra|apply IZR_lt in P].
    destruct (Z.leb_spec (2 * k) (- b)) as [Q|Q].
    + apply IZR_le in Q; rewrite mult_IZR, opp_IZR in Q; rewrite !plus_IZR.
      assert (0 <= (1 - x) * (- IZR b - IZR k * (1 + x))) by (apply Rmult_le_pos; nra); lra.
    + rewrite !minus_IZR; pose proof (rounded_down (b * b) (4 * k) ltac:(apply lt_IZR in K; lia)) as Rd; rewrite !mult_IZR in Rd.
      assert (IZR b * IZR b / (4 * IZR k) + (IZR b * x + IZR k * (x * x)) = (IZR b + 2 * IZR k * x) * (IZR b + 2 * IZR k * x) / (4 * IZR k)) by (field; lra).
      assert (0 <= (IZR b + 2 * IZR k * x) * (IZR b + 2 * IZR k * x) / (4 * IZR k)); [|lra].
      apply Rmult_le_pos; [apply Rle_0_sqr|left; apply Rinv_0_lt_compat; lra].
Qed.

Definition steady (A : list (list Z)) (W : list Z) (m : nat) (g : list Z) (e : Z) (ts : list (list Z)) : bool :=
  (weigh g W * worse m e <=? lowest (along_z g ts))%Z.
Fixpoint falling (A : list (list Z)) (W : list Z) (m : nat) (g : list Z) (e : Z) (tr : list (list (list Z))) : bool :=
  match tr with [] => true | ts :: r => steady A W m g e ts && falling A W m g (worse m e) r end.
Fixpoint keeps (A : list (list Z)) (W : list Z) (m : nat) (g up down : list Z) (known ends : bool) (e : Z) (tr : list (list (list Z))) : bool :=
  match tr with
  | [] => true
  | ts :: r => if steady A W m g e ts || known && steady A W m up e ts
               then keeps A W m g up down true ends (worse m e) r else ends && falling A W m down e tr
  end.

Lemma nth_add : forall u v k, nth k (add u v) 0%Z = (nth k u 0 + nth k v 0)%Z.
Proof. induction u as [|a u IH]; intros [|b v] [|k]; cbn [add nth]; try lia; apply IH. Qed.
Lemma zdot_place : forall k v, zdot (repeat 0%Z k ++ [1%Z]) v = nth k v 0%Z.
Proof. induction k as [|k IH]; intros [|x v]; cbn [repeat app zdot nth]; try reflexivity; [lia|]; rewrite IH; lia. Qed.
Lemma weigh_place : forall k W, weigh (repeat 0%Z k ++ [1%Z]) W = nth k W 0%Z.
Proof. induction k as [|k IH]; intros [|x v]; cbn [repeat app weigh nth]; try reflexivity; [lia|]; rewrite IH; lia. Qed.
Lemma terms_sum : forall k ts, peval (along_z (repeat 0%Z k ++ [1%Z]) ts) 1 = IZR (nth k (fold_right add [] ts) 0%Z).
Proof.
  intro k; induction ts as [|v ts IH]; cbn [along_z map peval fold_right]; [destruct k; reflexivity|].
  unfold along_z in IH; rewrite IH, nth_add, zdot_place, plus_IZR; ring.
Qed.
Lemma fold_length : forall n ts, Forall (fun v : list Z => length v = n) ts -> ts <> [] -> length (fold_right add [] ts) = n.
Proof.
  intros n ts F N; induction F as [|v ts L F IH]; [contradiction|]; cbn [fold_right]; destruct ts as [|w ts].
  - destruct v; exact L.
  - specialize (IH ltac:(discriminate)); revert L IH; generalize (fold_right add [] (w :: ts)); clear; revert n.
    induction v as [|a v IHv]; intros [|n] [|b l] E F; cbn in *; try lia; rewrite (IHv n l); lia.
Qed.
Lemma terms_length : forall A p q n m j v, length A = n -> length v = n -> Forall (fun v : list Z => length v = n) (terms_z A p q m j v).
Proof.
  intros A p q n; induction m as [|m IH]; intros j v LA Lv; cbn [terms_z]; constructor; auto.
  apply IH; [exact LA|unfold nextz; now rewrite map_length].
Qed.
Lemma worst_more : forall m K e E, (e <= E)%Z -> (0 <= e)%Z -> (0 <= worst m K e <= worst m K E)%Z.
Proof. intros m; induction K as [|K IH]; intros e E L N; cbn [worst]; [lia|]; apply IH; unfold worse; lia. Qed.
Lemma walk_later : forall A p q m K v e, walk A p q m (S K) v e <> None -> exists w, walk A p q m K v e = Some w /\ fits m w (worst m K e) = true.
Proof.
  intros A p q m; induction K as [|K IH]; intros v e H; cbn [walk] in H.
  - destruct (fits m v e) eqn:F; [|contradiction]; exists v; split; [reflexivity|exact F].
  - cbn [walk]; destruct (fits m v e) eqn:F; [|contradiction]; destruct (IH _ _ H) as [w [E G]]; now exists w.
Qed.

Section Walks.
Variables (n : nat) (d : Z) (A : list (list Z)) (W : list Z) (p q : Z).
Hypotheses (d0 : (0 < d)%Z) (p0 : (0 < p)%Z) (q0 : (0 < q)%Z) (LA : length A = n) (LW : length W = n)
  (w1 : Forall (fun w => 1 <= w)%Z W) (small : step_small A W p q = true).
Variables (f : nat -> R -> R) (m : nat).
Hypothesis flows : solves n d A f.
Let h := IZR d * IZR p / IZR q.
Definition near (s : R) (v : list Z) (e : Z) : Prop := length v = n /\ (0 <= e)%Z /\ within W (IZR e) (less (at_once n f s) v).

Lemma one_step : forall s v e E, near s v e -> (e <= E)%Z -> fits m v E = true -> forall g u, 0 <= u <= 1 ->
  Rabs (dot g (at_once n f (s + u * h)) - peval (along_z g (terms_z A p q m 0 v)) u) <= IZR (weigh g W) * IZR (worse m e).
Proof.
  intros s v e E [L [e0 H]] le F g u U; unfold fits in F; apply Z.leb_le in F; unfold worse.
  rewrite !plus_IZR, !mult_IZR, <- INR_IZR_INZ.
  apply (step_sound n d A W p q d0 p0 q0 LA LW w1 small f flows s v (IZR e) m L (IZR_le _ _ e0) H); [|exact U].
  rewrite <- plus_IZR, <- mult_IZR; apply IZR_le; lia.
Qed.
Lemma next_node : forall s v e E, near s v e -> (e <= E)%Z -> fits m v E = true -> near (s + h) (stepped A p q m v) (worse m e).
Proof.
  intros s v e E N le F; pose proof (one_step s v e E N le F) as T; destruct N as [L [e0 H]].
  assert (Ls : length (stepped A p q m v) = n).
  { apply fold_length; [now apply terms_length|destruct m; discriminate]. }
  split; [exact Ls|split; [unfold worse; lia|]]; intro k; rewrite nth_less by (unfold at_once; rewrite listed_length; congruence).
  specialize (T (repeat 0%Z k ++ [1%Z]) 1 ltac:(lra)); rewrite terms_sum, dot_place, weigh_place, !Rmult_1_l in T; exact T.
Qed.
Lemma after_steps : forall K s v e E w, near s v e -> (e <= E)%Z -> walk A p q m K v E = Some w ->
  near (s + INR K * h) w (worst m K e).
Proof.
  induction K as [|K IH]; intros s v e E w N le H.
  - injection H as <-; cbn [worst INR]; rewrite Rmult_0_l, Rplus_0_r; exact N.
  - cbn [walk] in H; destruct (fits m v E) eqn:F; [|discriminate].
    cbn [worst]; rewrite S_INR; replace (s + (INR K + 1) * h) with (s + h + INR K * h) by ring.
    apply (IH _ _ _ (worse m E)) with (3 := H); [apply (next_node s v e E); assumption|unfold worse; lia].
Qed.
Lemma bound_of : forall s v e E, near s v e -> (e <= E)%Z -> fits m v E = true -> within W (IZR (divisor m) / 2) (at_once n f s).
Proof.
  intros s v e E [L [e0 H]] le F k; unfold fits in F; apply Z.leb_le, IZR_le in F; rewrite mult_IZR, plus_IZR in F.
  destruct (Nat.lt_ge_cases k n) as [K|K].
  2: { rewrite !nth_overflow by (unfold at_once; rewrite ?listed_length; lia); rewrite Rabs_R0; lra. }
  specialize (H k); rewrite nth_less in H by (unfold at_once; rewrite listed_length; congruence).
  set (z := nth k (at_once n f s) 0) in *; apply IZR_le in le.
  assert (w0 : 1 <= IZR (nth k W 0%Z)) by (apply IZR_le; rewrite Forall_forall in w1; apply w1, nth_In; lia).
  replace z with (IZR (nth k v 0%Z) + (z - IZR (nth k v 0%Z))) by ring.
  apply Rle_trans with (1 := Rabs_triang _ _).
  assert (V : Rabs (IZR (nth k v 0%Z)) <= IZR (row_size v)).
  { clear; revert k; induction v as [|a v IH]; intros [|k]; cbn [nth row_size]; try (rewrite Rabs_R0; lra);
      rewrite plus_IZR, abs_IZR; [pose proof (row_size_nonneg v); lra|specialize (IH k); pose proof (Rabs_pos (IZR a)); lra]. }
  pose proof (row_size_nonneg v); set (D := IZR (divisor m)) in *; set (w := IZR (nth k W 0%Z)) in *.
  assert (w * (IZR (row_size v) + IZR E) <= w * (D / 2)) by (apply Rmult_le_compat_l; lra).
  assert (1 * IZR (row_size v) <= w * IZR (row_size v)) by (apply Rmult_le_compat_r; lra).
  assert (w * IZR e <= w * IZR E) by (apply Rmult_le_compat_l; lra); lra.
Qed.
(* How fast it moves in a step. *)
Lemma slowly : forall s b, 0 <= b -> within W b (at_once n f s) -> forall k u u', (k < n)%nat -> 0 <= u <= 1 -> 0 <= u' <= 1 ->
  Rabs (f k (s + u * h) - f k (s + u' * h)) <= IZR (nth k W 0%Z) * b * Rabs (u - u').
Proof.
  intros s b b0 B.
  assert (one : forall k u u', (k < n)%nat -> 0 <= u -> u < u' -> u' <= 1 ->
    Rabs (f k (s + u' * h) - f k (s + u * h)) <= IZR (nth k W 0%Z) * b * (u' - u)).
  { intros k u u' K U L U'.
    destruct (MVT_cor2 (fun u => f k (s + u * h)) (fun u => IZR p / IZR q * dot (nth k A []) (at_once n f (s + u * h))) u u' L)
      as [c [E C]]; [intros c _; exact (in_step n d A p q d0 q0 f flows k s c K)|].
    rewrite E, Rabs_mult, (Rabs_right (u' - u)) by lra; apply Rmult_le_compat_r; [lra|].
    replace b with (2 * b / 2) by field.
    apply (moved_within n A W p q p0 q0 LA LW w1 small); [apply listed_length| |lra|exact K].
    apply (bounded n d A W p q d0 p0 q0 LA LW w1 small f flows); [exact b0|exact B|lra]. }
  intros k u u' K U U'; destruct (Rtotal_order u u') as [L|[->|L]].
  - rewrite Rabs_minus_sym, (Rabs_minus_sym u), (Rabs_right (u' - u)) by lra; apply one; lra || exact K.
  - rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity; lra.
  - rewrite (Rabs_right (u - u')) by lra; apply one; lra || exact K.
Qed.
Lemma about_node : forall K v e E w, near 0 v e -> (e <= E)%Z -> walk A p q m (S (S K)) v E <> None ->
  walk A p q m (S K) v E = Some w -> forall k th, (k < n)%nat -> Rabs th <= 1 ->
  Rabs (f k ((INR (S K) + th) * h) - IZR (nth k w 0%Z)) <= IZR (nth k W 0%Z) * (IZR (worst m (S K) e) + IZR (divisor m) * Rabs th).
Proof.
  intros K v e E w N le H H1 k th Kn T; destruct (walk_later _ _ _ _ _ _ _ H) as [w' [E' F']].
  rewrite H1 in E'; injection E' as <-.
  destruct (walk_later A p q m K v E ltac:(congruence)) as [y [E2 F2]].
  pose proof (after_steps (S K) 0 v e E w N le H1) as N1; pose proof (after_steps K 0 v e E y N le E2) as N2.
  destruct N as [_ [e0 _]]; pose proof (worst_more m K e E le e0) as M2; pose proof (worst_more m (S K) e E le e0) as M1.
  pose proof (bound_of _ _ _ _ N1 (proj2 M1) F') as B1; pose proof (bound_of _ _ _ _ N2 (proj2 M2) F2) as B2.
  pose proof (divisor_pos m) as D.
  assert (G : Rabs (f k ((INR (S K) + th) * h) - f k (INR (S K) * h)) <= IZR (nth k W 0%Z) * (IZR (divisor m) / 2) * Rabs th).
  { apply abs_both in T; destruct (Rle_dec 0 th) as [P|P].
    - pose proof (slowly _ (IZR (divisor m) / 2) ltac:(lra) B1 k th 0 Kn ltac:(lra) ltac:(lra)) as Q; rewrite Rminus_0_r in Q.
      replace ((INR (S K) + th) * h) with (0 + INR (S K) * h + th * h) by ring.
      replace (INR (S K) * h) with (0 + INR (S K) * h + 0 * h) at 2 by ring; exact Q.
    - pose proof (slowly _ (IZR (divisor m) / 2) ltac:(lra) B2 k (1 + th) 1 Kn ltac:(lra) ltac:(lra)) as Q; rewrite S_INR.
      replace ((INR K + 1 + th) * h) with (0 + INR K * h + (1 + th) * h) by ring.
      replace ((INR K + 1) * h) with (0 + INR K * h + 1 * h) by ring; replace th with (1 + th - 1) at 2 by ring; exact Q. }
  destruct N1 as [L1 [_ N1]]; specialize (N1 k); rewrite nth_less in N1 by (unfold at_once; rewrite listed_length; congruence).
  unfold at_once, listed in N1; rewrite nth_listed in N1 by exact Kn; rewrite Rplus_0_l in N1.
  replace (f k ((INR (S K) + th) * h) - IZR (nth k w 0%Z))
    with ((f k ((INR (S K) + th) * h) - f k (INR (S K) * h)) + (f k (INR (S K) * h) - IZR (nth k w 0%Z))) by ring.
  apply Rle_trans with (1 := Rabs_triang _ _).
  assert (w0 : 0 <= IZR (nth k W 0%Z)) by (apply Rle_trans with 1; [lra|]; apply IZR_le; rewrite Forall_forall in w1; apply w1, nth_In; lia).
  pose proof (Rmult_le_pos _ _ w0 (Rmult_le_pos _ _ (Rlt_le _ _ D) (Rabs_pos th))); lra.
Qed.

(* A form that stays nonnegative. *)
Lemma form_flow : forall g t, derivable_pt_lim (fun t => dot g (at_once n f t)) t (dot (combine_forms g A) (at_once n f t) / IZR d).
Proof.
  intros g t; unfold at_once, listed.
  apply (derivable_same (fun t => dot g (map (fun i => f i t) (seq 0 n))) _ t
    (dot g (map (fun i => dot (nth i A []) (listed n (fun i => f i t)) / IZR d) (seq 0 n))));
    [reflexivity| |apply dot_flow; intros i I; apply flows; lia].
  rewrite dot_combine; fold (listed n (fun i => f i t)); set (z := listed n (fun i => f i t)).
  rewrite <- dot_part, <- LA; f_equal; apply rows_by_place.
Qed.
Lemma h_0 : 0 < h.
Proof. apply (h_pos d p q); assumption. Qed.
Lemma steady_sound : forall s v e E g, near s v e -> (e <= E)%Z -> fits m v E = true -> steady A W m g E (terms_z A p q m 0 v) = true ->
  forall t, s <= t <= s + h -> 0 <= dot g (at_once n f t).
Proof.
  intros s v e E g N le F T t I; unfold steady in T; apply Z.leb_le, IZR_le in T; rewrite mult_IZR in T.
  pose proof h_0 as H; set (u := (t - s) / h).
  assert (U : 0 <= u <= 1) by (unfold u; apply quotient; lra).
  pose proof (one_step s v e E N le F g u U) as B; apply abs_both in B.
  replace (s + u * h) with t in B by (unfold u; field; lra).
  pose proof (lowest_sound (along_z g (terms_z A p q m 0 v)) u U) as L.
  pose proof (weigh_nonneg g W w1) as Wg.
  assert (IZR (worse m e) <= IZR (worse m E)) by (apply IZR_le; unfold worse; lia).
  assert (IZR (weigh g W) * IZR (worse m e) <= IZR (weigh g W) * IZR (worse m E)) by (apply Rmult_le_compat_l; lra); lra.
Qed.
Lemma falling_sound : forall K s v e E g, near s v e -> (e <= E)%Z -> walk A p q m K v E <> None ->
  falling A W m g E (trace A p q m K v) = true -> forall t, s <= t <= s + INR K * h -> K <> O -> 0 <= dot g (at_once n f t).
Proof.
  induction K as [|K IH]; intros s v e E g N le H T t I K0; [contradiction|].
  cbn [walk trace falling] in H, T; destruct (fits m v E) eqn:F; [|contradiction]; apply andb_true_iff in T as [T T'].
  destruct (Rle_dec t (s + h)) as [L|L]; [apply (steady_sound s v e E g); auto; lra|].
  rewrite S_INR in I; destruct K as [|K]; [cbn in I; lra|].
  apply (IH (s + h) _ (worse m e) (worse m E) g (next_node s v e E N le F) ltac:(unfold worse; lia) H T'); [lra|discriminate].
Qed.
Lemma keeps_sound : forall g tend ends K s v e E known, near s v e -> (e <= E)%Z -> walk A p q m K v E <> None ->
  keeps A W m g (combine_forms g A) (scale (-1) (combine_forms g A)) known ends E (trace A p q m K v) = true ->
  (known = true -> 0 <= dot g (at_once n f s)) -> (ends = true -> 0 <= dot g (at_once n f tend)) ->
  tend <= s + INR K * h -> K <> O -> forall t, s <= t <= tend -> 0 <= dot g (at_once n f t).
Proof.
  intros g tend ends; induction K as [|K IH]; intros s v e E known N le H T Kn En M K0 t I; [contradiction|].
  pose proof h_0 as hp; assert (dp : 0 < IZR d) by now apply IZR_lt.
  cbn [trace keeps] in T; set (ts := terms_z A p q m 0 v) in *.
  destruct (steady A W m g E ts || known && steady A W m (combine_forms g A) E ts) eqn:G.
  - cbn [walk] in H; destruct (fits m v E) eqn:F; [|contradiction].
    assert (now : forall t, s <= t <= s + h -> 0 <= dot g (at_once n f t)).
    { apply orb_true_iff in G as [G|G]; [apply (steady_sound s v e E g); auto|]; apply andb_true_iff in G as [k1 G].
      intros r R0; specialize (Kn k1); destruct (proj1 R0) as [L|<-]; [|exact Kn].
      destruct (MVT_cor2 _ _ s r L (fun c _ => form_flow g c)) as [c [E1 C]].
      pose proof (steady_sound s v e E _ N le F G c ltac:(lra)) as Q.
      assert (0 <= dot (combine_forms g A) (at_once n f c) / IZR d) by (apply Rmult_le_pos; [exact Q|left; now apply Rinv_0_lt_compat]); nra. }
    destruct (Rle_dec t (s + h)) as [L|L]; [apply now; lra|].
    rewrite S_INR in M; destruct K as [|K]; [cbn in M; lra|].
    apply (IH (s + h) _ (worse m e) (worse m E) true (next_node s v e E N le F) ltac:(unfold worse; lia) H T); auto; try lra; try discriminate.
    intros _; apply now; lra.
  - apply andb_true_iff in T as [e1 T]; specialize (En e1); destruct (proj2 I) as [L|<-]; [|exact En].
    destruct (MVT_cor2 _ _ t tend L (fun c _ => form_flow g c)) as [c [E1 C]].
    pose proof (falling_sound (S K) s v e E _ N le H T c ltac:(lra) ltac:(discriminate)) as Q; rewrite dot_scale in Q.
    assert (0 <= - dot (combine_forms g A) (at_once n f c) / IZR d) by (apply Rmult_le_pos; [lra|left; now apply Rinv_0_lt_compat]).
    unfold Rdiv in *; nra.
Qed.
End Walks.
